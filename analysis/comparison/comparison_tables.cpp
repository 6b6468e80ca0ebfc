// The comparison as CSV and JSON.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/comparison/comparison_report.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using json = nlohmann::ordered_json;

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

/// onset_ms,peak_ms,offset_ms; empty where nothing moves, and the offset where it does not end.
std::string timing_cells(const std::optional<MovementTiming>& t) {
  if (!t) return ",,,";
  return "," + format_fixed(1e3 * t->onset_s, 1) + "," + format_fixed(1e3 * t->peak_s, 1) + "," +
         (t->comes_back ? format_fixed(1e3 * t->offset_s, 1) : "");
}

json timing_json(const std::optional<MovementTiming>& t) {
  if (!t) return nullptr;
  json out{{"onset_ms", 1e3 * t->onset_s}, {"peak_ms", 1e3 * t->peak_s}};
  out["offset_ms"] = t->comes_back ? json(1e3 * t->offset_s) : json(nullptr);
  return out;
}

json course_json(const RegionCourse& c) {
  return {{"largest_mm", c.largest_mm},
          {"largest_strain_percent", c.largest_strain},
          {"timing", timing_json(c.timing)}};
}

json course_json(const MeasureCourse& c) {
  return {{"rest_mm", c.rest_mm},
          {"change_mm", c.change_mm},
          {"peak_speed_mm_s", c.peak_speed},
          {"timing", timing_json(c.timing)}};
}

json side_json(const Asymmetry& a) {
  return {{"left_mm", a.left_mm},
          {"right_mm", a.right_mm},
          {"percent", a.percent},
          {"onset_ms", std::isfinite(a.onset_ms) ? json(a.onset_ms) : json(nullptr)}};
}

json truth_json(const MapEvaluation& e) {
  return {{"mean", e.errors.mean},
          {"median", e.errors.median},
          {"percentile_95", e.errors.p95},
          {"worst", e.errors.worst},
          {"unmapped", e.errors.unmapped}};
}

json correspondence_json(const ComparisonStory& story) {
  const Comparison& c = story.comparison;
  json out{{"found", c.correspondence},
           {"poor", c.poor},
           {"mean_confidence", c.mean_confidence},
           {"doubtful", json::array()}};
  for (const DoubtfulPlace& d : c.doubtful)
    out["doubtful"].push_back({{"vertex", d.source}, {"confidence", d.confidence}});
  if (story.truth) out["errors_over_root_area"] = truth_json(*story.truth);
  return out;
}

json time_json(const Comparison& c) {
  if (!c.warp) return nullptr;
  return {{"delay_ms", 1e3 * c.warp->delay_s},
          {"amplitude_b_over_a", c.warp->amplitude},
          {"difference", c.warp->difference}};
}

json inputs_json(const Provenance& provenance) {
  json inputs = json::array();
  for (const Provenance::Input& i : provenance.inputs)
    inputs.push_back({{"path", i.path}, {"sha256", i.sha256}});
  return inputs;
}

}  // namespace

std::string measures_csv(const ComparisonStory& story) {
  std::string csv =
      "measure,performance,rest_mm,change_mm,peak_speed_mm_s,onset_ms,peak_ms,offset_ms\n";
  for (const MeasureResult& m : story.measures) {
    for (const auto& [name, c] : {std::pair{&story.name_a, &m.a}, {&story.name_b, &m.b}}) {
      csv += quoted(m.spec.name) + "," + quoted(*name) + "," + format_fixed(c->rest_mm, 4) + "," +
             format_fixed(c->change_mm, 4) + "," + format_fixed(c->peak_speed, 3) +
             timing_cells(c->timing) + "\n";
    }
  }
  return csv;
}

std::string regions_csv(const ComparisonStory& story) {
  std::string csv =
      "region,performance,largest_mm,largest_strain_percent,onset_ms,peak_ms,offset_ms,"
      "shape_mean_mm,shape_rms_mm,motion_rms_mm,motion_largest_mm\n";
  for (const RegionResult& r : story.regions) {
    for (const auto& [name, c] : {std::pair{&story.name_a, &r.a}, {&story.name_b, &r.b}}) {
      csv += quoted(r.region.name) + "," + quoted(*name) + "," + format_fixed(c->largest_mm, 4) +
             "," + format_fixed(c->largest_strain, 3) + timing_cells(c->timing) + "," +
             format_fixed(r.shape_mean_mm, 4) + "," + format_fixed(r.shape_rms_mm, 4) + "," +
             format_fixed(r.motion_rms_mm, 4) + "," + format_fixed(r.motion_largest_mm, 4) + "\n";
    }
  }
  return csv;
}

std::vector<double> in_time_of_a(const Comparison& c, const std::vector<double>& of_b) {
  std::vector<double> result(c.a.frame_count, std::nan(""));
  for (std::size_t f = 0; f < result.size() && !of_b.empty(); ++f) {
    const double last = static_cast<double>(of_b.size() - 1);
    const double frame = c.warp ? std::clamp(c.warp->b_of_a_s[f] * c.b.rate_hz, 0.0, last) : 0.0;
    const auto before = static_cast<std::size_t>(frame);
    const std::size_t after = std::min(before + 1, of_b.size() - 1);
    const double t = frame - static_cast<double>(before);
    result[f] = (1.0 - t) * of_b[before] + t * of_b[after];
  }
  return result;
}

std::string curves_csv(const ComparisonStory& story) {
  const Comparison& c = story.comparison;
  std::string csv = "a_s,b_s";
  std::vector<std::vector<double>> columns;
  const auto add = [&](const std::string& name, const std::vector<double>& of_a,
                       const std::vector<double>& of_b) {
    csv += "," + quoted(name + ", A (mm)") + "," + quoted(name + ", B (mm)");
    columns.push_back(of_a);
    columns.push_back(in_time_of_a(c, of_b));
  };
  for (const RegionResult& r : story.regions) add(r.region.name, r.a.amount_mm, r.b.amount_mm);
  for (const MeasureResult& m : story.measures) add(m.spec.name, m.a.mm, m.b.mm);
  for (std::size_t f = 0; f < c.a.frame_count; ++f) {
    const double time = c.a.rate_hz > 0.0 ? static_cast<double>(f) / c.a.rate_hz : 0.0;
    csv += "\n" + format_number(time) + "," + (c.warp ? format_number(c.warp->b_of_a_s[f]) : "");
    for (const auto& column : columns) csv += "," + format_fixed(column[f], 4);
  }
  return csv + "\n";
}

std::string comparison_json(const ComparisonStory& story) {
  const Comparison& c = story.comparison;
  json out{{"format", "kinemesh comparison"},
           {"program", story.provenance.program},
           {"command", story.provenance.command},
           {"inputs", inputs_json(story.provenance)},
           {"a", story.name_a},
           {"b", story.name_b},
           {"doubtful", doubts_of(story)},
           {"correspondence", correspondence_json(story)},
           {"time", time_json(c)},
           {"root_area_a_mm", c.root_area_mm},
           {"scale_of_b", c.scale}};
  for (const RegionResult& r : story.regions) {
    out["regions"].push_back({{"region", r.region.name},
                              {"vertices", r.region.vertices.size()},
                              {"shape_difference_mean_mm", r.shape_mean_mm},
                              {"shape_difference_rms_mm", r.shape_rms_mm},
                              {"motion_difference_rms_mm", r.motion_rms_mm},
                              {"motion_difference_largest_mm", r.motion_largest_mm},
                              {"a", course_json(r.a)},
                              {"b", course_json(r.b)}});
  }
  out["measures"] = json::array();
  for (const MeasureResult& m : story.measures) {
    out["measures"].push_back(
        {{"measure", m.spec.name}, {"a", course_json(m.a)}, {"b", course_json(m.b)}});
  }
  out["asymmetry"] = json::array();
  for (const AsymmetryRow& row : story.asymmetry) {
    out["asymmetry"].push_back(
        {{"of", row.name}, {"a", side_json(row.a)}, {"b", side_json(row.b)}});
  }
  out["options"] = story.provenance.options;
  return out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace kinemesh
