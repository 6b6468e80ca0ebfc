#include "analysis/comparison/comparison_report.h"

#include <algorithm>
#include <cmath>

#include "analysis/comparison/comparison_views.h"
#include "analysis/map_evaluation_view.h"
#include "config/text.h"
#include "report/chart.h"
#include "report/html/components.h"
#include "report/html/page.h"

namespace kinemesh {
namespace {

std::string sentence(std::string text) {
  if (!text.empty()) text.front() = upper(text.substr(0, 1)).front();
  return text.empty() || text.back() == '.' ? text : text + ".";
}

std::string mm(double value, int decimals = 2) { return format_fixed(value, decimals); }

/// With its sign, also for what is added.
std::string difference(double value, int decimals) {
  std::string text = format_fixed(std::abs(value), decimals);
  if (text.find_first_not_of("0.") == std::string::npos) return text;
  return (value < 0 ? "−" : "+") + text;
}

std::string ms(double seconds) { return format_fixed(1e3 * seconds, 0); }

std::string onset(const std::optional<MovementTiming>& t) { return t ? ms(t->onset_s) : "–"; }
std::string peak(const std::optional<MovementTiming>& t) { return t ? ms(t->peak_s) : "–"; }
std::string offset(const std::optional<MovementTiming>& t) {
  if (!t) return "–";
  return t->comes_back ? ms(t->offset_s) : "not over";
}

std::string place_words(const DoubtfulPlace& d, const ComparisonStory& story) {
  const AnimatedMesh& a = story.a.mesh;
  std::string text = "vertex " + std::to_string(d.source);
  if (a.vertex_names.size() == a.vertex_count()) text += " (" + a.vertex_names[d.source] + ")";
  text += " of A";
  if (!d.target.valid()) return text + ", which has no counterpart";
  const auto& w = d.target.weights;
  const auto corner = static_cast<std::size_t>(std::ranges::max_element(w) - w.begin());
  const VertexIndex v = story.b.mesh.topology().faces()[d.target.face][corner];
  return text + ", taken to be near vertex " + std::to_string(v) + " of B";
}

Figures figures_of(const ComparisonStory& story) {
  const Comparison& c = story.comparison;
  const RegionResult& whole = story.regions.front();
  Figures figures;
  figures.entries = {
      {format_fixed(100.0 * c.mean_confidence, 0) + " %", "confidence of the correspondence"},
      {mm(whole.shape_rms_mm) + " mm", "shape difference at rest (RMS)"}};
  if (!c.warp) return figures;
  figures.entries.push_back({mm(whole.motion_rms_mm) + " mm", "motion difference (RMS)"});
  figures.entries.push_back({difference(1e3 * c.warp->delay_s, 0) + " ms",
                             c.warp->delay_s < 0 ? "B is earlier" : "B is later"});
  figures.entries.push_back({mm(whole.a.largest_mm, 1) + " / " + mm(whole.b.largest_mm, 1) + " mm",
                             "largest movement of A / B (RMS)"});
  return figures;
}

void add_first(HtmlPage& page, const ComparisonStory& story) {
  HtmlSection& section = page.add_section("Look at this first");
  section.add(WarningList{doubts_of(story), "Nothing doubtful was found in this comparison."})
      .add(figures_of(story))
      .add(Paragraph{"Correspondence: " + story.comparison.correspondence + "."});
}

void add_views(HtmlPage& page, const ComparisonStory& story, const RunContext& ctx) {
  const auto [a, b] = comparison::viewers_of(story, ctx);
  page.add_section("Both faces")
      .add_beside(a, b)
      .add(Paragraph{
          "Both turn and play together, B at the instants that correspond to A's. Motion is what "
          "moves from each face's own rest pose and is free of the difference in shape; shape "
          "difference is the signed distance of B's rest surface from A's, after B was turned and "
          "moved onto A" +
              std::string(story.comparison.scale != 1.0 ? " and scaled" : "") +
              ". Colour scales are fixed over time and common to both. Grey: no counterpart.",
          true});
}

Series curve(const std::string& label, const std::vector<double>& y, double rate,
             std::size_t colour) {
  Series series{.label = label, .y = y, .colour = series_colour(colour)};
  for (std::size_t f = 0; f < y.size(); ++f)
    series.x.push_back(rate > 0 ? static_cast<double>(f) / rate : static_cast<double>(f));
  return series;
}

/// Small charts in two columns, A and B in A's time.
struct CurveGrid {
  static constexpr double width = 1000.0, height = 210.0;
  const ComparisonStory& story;
  std::vector<LineChart> charts;

  void add(const std::string& title, const std::string& label, const std::vector<double>& of_a,
           const std::vector<double>& of_b) {
    const double rate = story.comparison.a.rate_hz;
    LineChart chart{.title = title,
                    .x = {.label = "time of A", .unit = "s"},
                    .y = {.label = label, .unit = "mm"}};
    chart.series = {curve("A", of_a, rate, 0),
                    curve("B", in_time_of_a(story.comparison, of_b), rate, 1)};
    charts.push_back(std::move(chart));
  }
  Canvas drawn() const {
    const std::size_t rows = (charts.size() + 1) / 2;
    Canvas canvas(width, height * static_cast<double>(rows));
    for (std::size_t k = 0; k < charts.size(); ++k) {
      const std::size_t row = k / 2, column = k % 2;
      charts[k].draw(canvas, {static_cast<double>(column) * width / 2 + 5,
                              static_cast<double>(row) * height + 5, width / 2 - 10, height - 10});
    }
    return canvas;
  }
};

void add_regions(HtmlPage& page, const ComparisonStory& story) {
  Table table{"What differs where (mm)",
              {{"region"},
               {"shape, mean", true},
               {"shape, RMS", true},
               {"motion, RMS", true},
               {"motion, largest", true}},
              {}};
  Table each{"What each does there, at its largest",
             {{"region"},
              {"A moves (mm)", true},
              {"B moves (mm)", true},
              {"A stretches (%)", true},
              {"B stretches (%)", true}},
             {}};
  Table times{"When each region moves (ms, each in its own time)",
              {{"region"},
               {"A onset", true},
               {"A peak", true},
               {"A offset", true},
               {"B onset", true},
               {"B peak", true},
               {"B offset", true}},
              {}};
  CurveGrid grid{story, {}};
  for (const RegionResult& r : story.regions) {
    table.rows.push_back({r.region.name, difference(r.shape_mean_mm, 2), mm(r.shape_rms_mm),
                          mm(r.motion_rms_mm), mm(r.motion_largest_mm)});
    each.rows.push_back({r.region.name, mm(r.a.largest_mm), mm(r.b.largest_mm),
                         mm(r.a.largest_strain, 1), mm(r.b.largest_strain, 1)});
    times.rows.push_back({r.region.name, onset(r.a.timing), peak(r.a.timing), offset(r.a.timing),
                          onset(r.b.timing), peak(r.b.timing), offset(r.b.timing)});
    grid.add(r.region.name, "movement", r.a.amount_mm, r.b.amount_mm);
  }
  HtmlSection& section = page.add_section("Regions");
  section.add(table).add(each).add(times);
  section.add(
      Figure{grid.drawn(), "How far each region has moved towards its strongest pose", "", 720.0});
  section.add(Paragraph{
      "Left and right are the subject's own. Movement is the displacement along that of the "
      "region's strongest pose (RMS over its area). Onset and peak are followed back to where the "
      "movement leaves rest and where it reaches its level, so that no threshold delays them.",
      true});
}

void add_measures(HtmlPage& page, const ComparisonStory& story) {
  if (story.measures.empty()) return;
  Table table{"Clinical measures (timing in ms, each in its own time)",
              {{"measure"},
               {"of"},
               {"at rest (mm)", true},
               {"change (mm)", true},
               {"peak speed (mm/s)", true},
               {"onset", true},
               {"peak", true},
               {"offset", true}},
              {}};
  CurveGrid grid{story, {}};
  for (const MeasureResult& m : story.measures) {
    for (const auto& [name, c] : {std::pair{"A", &m.a}, {"B", &m.b}}) {
      table.rows.push_back({m.spec.name, name, mm(c->rest_mm), difference(c->change_mm, 2),
                            mm(c->peak_speed, 1), onset(c->timing), peak(c->timing),
                            offset(c->timing)});
    }
    const auto late = [](const MeasureCourse& c) { return c.timing ? c.timing->peak_s : 0.0; };
    const bool both = m.a.timing && m.b.timing;
    table.rows.push_back(
        {"", "B − A", difference(m.b.rest_mm - m.a.rest_mm, 2),
         difference(m.b.change_mm - m.a.change_mm, 2),
         difference(m.b.peak_speed - m.a.peak_speed, 1),
         both ? difference(1e3 * (m.b.timing->onset_s - m.a.timing->onset_s), 0) : "–",
         both ? difference(1e3 * (late(m.b) - late(m.a)), 0) : "–",
         both && m.a.timing->comes_back && m.b.timing->comes_back
             ? difference(1e3 * (m.b.timing->offset_s - m.a.timing->offset_s), 0)
             : "–"});
    grid.add(m.spec.name, "length", m.a.mm, m.b.mm);
  }
  page.add_section("Measures")
      .add(table)
      .add(Figure{grid.drawn(), "Measures over time", "", 720.0});
}

void add_asymmetry(HtmlPage& page, const ComparisonStory& story) {
  if (story.asymmetry.empty()) return;
  Table table{"Left against right (positive: the subject's left does more, or starts later)",
              {{"of"},
               {"A left / right (mm)", true},
               {"A (%)", true},
               {"A onset (ms)", true},
               {"B left / right (mm)", true},
               {"B (%)", true},
               {"B onset (ms)", true}},
              {}};
  const auto late = [](const Asymmetry& s) {
    return std::isfinite(s.onset_ms) ? difference(s.onset_ms, 0) : "–";
  };
  const auto sides = [](const Asymmetry& s) { return mm(s.left_mm) + " / " + mm(s.right_mm); };
  for (const AsymmetryRow& row : story.asymmetry) {
    table.rows.push_back({row.name, sides(row.a), difference(row.a.percent, 1), late(row.a),
                          sides(row.b), difference(row.b.percent, 1), late(row.b)});
  }
  page.add_section("Left and right").add(table);
}

void add_time(HtmlPage& page, const ComparisonStory& story) {
  const Comparison& c = story.comparison;
  if (!c.warp) return;
  std::vector<double> delay;
  for (std::size_t f = 0; f < c.a.frame_count; ++f) {
    const double time = static_cast<double>(f) / c.a.rate_hz;
    delay.push_back(c.warp->determined[f] != 0 ? 1e3 * (c.warp->b_of_a_s[f] - time) : std::nan(""));
  }
  LineChart chart{.title = "How much later B does what A does, where something moves",
                  .x = {.label = "time of A", .unit = "s"},
                  .y = {.label = "delay", .unit = "ms", .from_zero = true}};
  chart.series = {curve("delay", delay, c.a.rate_hz, 2)};
  page.add_section("Time").add(Figure{canvas_of(chart, 1000.0, 240.0), chart.title, "", 640.0});
}

void add_truth(HtmlPage& page, const ComparisonStory& story) {
  if (!story.truth) return;
  const MapErrors& e = story.truth->errors;
  const LineChart chart = error_curves({"A → B"}, {*story.truth}, story.truth_cutoff);
  page.add_section("Error of the correspondence")
      .add(KeyValues{{{"mean", format_fixed(e.mean, 4) + " √area"},
                      {"median", format_fixed(e.median, 4) + " √area"},
                      {"95 %", format_fixed(e.p95, 4) + " √area"},
                      {"worst", format_fixed(e.worst, 4) + " √area"}}})
      .add(Figure{canvas_of(chart, 720.0, 400.0), chart.title});
}

void add_origin(HtmlPage& page, const ComparisonStory& story) {
  const Provenance& made = story.provenance;
  HtmlSection& section = page.add_section("How it was made");
  section.add(KeyValues{{{"program", made.program}}})
      .add(CodeBlock{"Command that makes it again", made.command})
      .add(CodeBlock{"All options (TOML, for --config)", made.options, true});
  std::string hashes;
  for (const Provenance::Input& input : made.inputs)
    hashes += input.sha256 + "  " + input.path + "\n";
  section.add(CodeBlock{"Inputs (SHA-256, for sha256sum -c)", hashes});
}

std::string size_text(const AnimatedMesh& mesh) {
  return count_of(mesh.vertex_count(), "vertex", "vertices") + ", " +
         format_fixed(mesh.duration_s(), 1) + " s";
}

}  // namespace

std::vector<std::string> doubts_of(const ComparisonStory& story) {
  std::vector<std::string> doubts;
  const Comparison& c = story.comparison;
  if (c.poor) doubts.emplace_back("POOR CORRESPONDENCE: no figure below is to be trusted.");
  for (const std::string& warning : c.warnings) doubts.push_back(sentence(warning));
  for (const DoubtfulPlace& d : c.doubtful) {
    doubts.push_back("Add a landmark here: the correspondence is doubtful at " +
                     place_words(d, story) + " (confidence " +
                     format_fixed(100.0 * d.confidence, 0) + " %).");
  }
  for (const std::string& note : story.a.notes) doubts.push_back(sentence("A: " + note));
  for (const std::string& note : story.b.notes) doubts.push_back(sentence("B: " + note));
  return doubts;
}

std::string comparison_html(const ComparisonStory& story, const RunContext& ctx) {
  HtmlPage page("Comparison of two performances",
                "A: " + story.name_a + " (" + size_text(story.a.mesh) + ") · B: " + story.name_b +
                    " (" + size_text(story.b.mesh) + ")",
                story.provenance.program);
  add_first(page, story);
  add_views(page, story, ctx);
  add_measures(page, story);
  add_regions(page, story);
  add_asymmetry(page, story);
  add_time(page, story);
  add_truth(page, story);
  add_origin(page, story);
  return page.html();
}

}  // namespace kinemesh
