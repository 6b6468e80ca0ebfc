#include "reconstruct/convert_summary.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "config/text.h"

namespace kinemesh {
namespace {

using Json = nlohmann::ordered_json;

/// More of one kind are told in one sentence.
constexpr std::size_t most_sentences = 8;

std::string label_of(const Marker& marker) { return marker.label; }

std::size_t filled_frames(const ConvertResult& result) {
  std::size_t sum = 0;
  for (const Fill& fill : result.fills) sum += fill.frames.size();
  return sum;
}

double seconds(const ConvertResult& result, std::size_t frames) {
  const double rate = result.animation.rate_hz;
  return rate > 0 ? static_cast<double>(frames) / rate : 0.0;
}

std::vector<std::string> labels_of(const Opening& opening, const ConvertResult& result) {
  std::vector<std::string> labels;
  for (const VertexIndex v : opening.loop) labels.push_back(label_of(result.markers[v]));
  return labels;
}

/// "left out: 6 of the head rig, 1 unlabelled": how many markers, by reason.
std::string left_out_text(const MarkerSelectionResult& selection) {
  std::map<std::string, std::size_t> counts;
  for (const MarkerDecision& decision : selection.decisions) {
    if (!decision.chosen) ++counts[decision.text];
  }
  std::vector<std::string> parts;
  for (const auto& [text, count] : counts)
    parts.push_back(std::to_string(count) + " (" + text + ")");
  return join(parts, "; ");
}

std::string openings_text(const ConvertResult& result) {
  if (result.triangulation.openings.empty()) return "none";
  std::vector<std::string> parts;
  for (const Opening& opening : result.triangulation.openings) {
    parts.push_back(std::string(name_of(opening.name)) + " (ring of " +
                    count_of(opening.loop.size(), "marker") +
                    (opening.forced       ? ", as asked for)"
                     : opening.score == 0 ? ")"  // taken over from another mesh, or a gap
                                          : ", score " + format_fixed(opening.score, 2) + ")"));
  }
  return join(parts, "; ");
}

Json gaps_json(const ConvertResult& result) {
  Json list = Json::array();
  for (std::size_t v = 0; v < result.gaps.size(); ++v) {
    const MarkerGaps& gaps = result.gaps[v];
    Json fills = Json::array();
    for (const Fill& fill : result.fills) {
      if (fill.marker != v) continue;
      fills.push_back(
          {{"first_frame", result.animation.first_frame + static_cast<int64_t>(fill.frames.begin)},
           {"frames", fill.frames.size()},
           {"method", name_of(fill.method)},
           {"mean_sd_mm", fill.mean_sd_mm},
           {"max_sd_mm", fill.max_sd_mm}});
    }
    const FillUncertainty uncertainty = uncertainty_of(result, v);
    list.push_back({{"label", result.markers[v].label},
                    {"subject", result.markers[v].subject},
                    {"missing_percent", gaps.missing_percent},
                    {"gaps", gaps.gaps.size()},
                    {"longest_gap_s", seconds(result, gaps.longest)},
                    {"filled_frames", uncertainty.frames},
                    {"mean_uncertainty_mm", uncertainty.mean_mm},
                    {"max_uncertainty_mm", uncertainty.max_mm},
                    {"fills", std::move(fills)}});
  }
  return list;
}

Json openings_json(const ConvertResult& result) {
  Json list = Json::array();
  for (const Opening& opening : result.triangulation.openings) {
    list.push_back({{"name", name_of(opening.name)},
                    {"score", opening.score},
                    {"forced", opening.forced},
                    {"markers", labels_of(opening, result)},
                    {"vertices", opening.loop}});
  }
  return list;
}

Json candidates_json(const ConvertResult& result) {
  Json list = Json::array();
  for (const OpeningCandidate& candidate : result.triangulation.candidates) {
    list.push_back({{"name", name_of(candidate.name)},
                    {"score", candidate.score},
                    {"threshold", candidate.threshold},
                    {"opened", candidate.opened},
                    {"reason", candidate.reason}});
  }
  return list;
}

Json left_out_json(const MarkerSequence& session, const MarkerSelectionResult& selection) {
  Json list = Json::array();
  for (std::size_t m = 0; m < selection.decisions.size(); ++m) {
    if (selection.decisions[m].chosen) continue;
    list.push_back(
        {{"label", session.markers()[m].label}, {"reason", selection.decisions[m].text}});
  }
  return list;
}

Json mesh_json(const ConvertResult& result) {
  const Topology& topology = result.animation.topology();
  const TriangulateDiagnostics& d = result.triangulation.diagnostics;
  return {{"vertices", topology.vertex_count()},
          {"faces", topology.face_count()},
          {"boundary_loops", topology.boundary_loops().size()},
          {"euler_characteristic", topology.euler_characteristic()},
          {"manifold", topology.is_manifold()},
          {"reference_frame", result.triangulation.frame_number},
          {"reference_frame_measured", result.triangulation.all_measured},
          {"marker_spacing_mm", d.spacing},
          {"method", d.method},
          {"openings", openings_json(result)},
          {"openings_considered", candidates_json(result)}};
}

Json quality_json(const ConvertResult& result) {
  const CarrySummary& s = result.summary;
  return {{"samples", s.samples},
          {"filled_samples", s.filled_samples},
          {"frames_with_flipped_triangles", s.frames_with_flips},
          {"worst_frame", result.animation.first_frame + static_cast<int64_t>(s.worst_frame)},
          {"worst_frame_triangles", s.worst_count},
          {"edge_stretch_min", s.stretch_min},
          {"edge_stretch_max", s.stretch_max}};
}

/// Score from which an opening is cut unasked, with the standard options.
double threshold_of(const Opening& opening) {
  return opening.name == OpeningName::mouth ? OpeningOptions{}.mouth_seed
                                            : OpeningOptions{}.eye_score;
}

std::string suspects_text(const ConvertResult& result) {
  std::vector<std::string> labels;
  for (const VertexIndex v : result.summary.flip_suspects) {
    labels.push_back(label_of(result.markers[v]));
  }
  return labels.empty() ? "" : ", first of all " + join(labels, ", ");
}

/// Markers that are missing for long, one by one or, when they are many, in one sentence.
void doubt_missing(const ConvertResult& result, std::vector<std::string>& doubts) {
  std::vector<const MarkerGaps*> long_ones;
  for (const MarkerGaps& gaps : result.gaps) {
    if (gaps.missing_percent > 20.0) long_ones.push_back(&gaps);
  }
  std::size_t longest = 0;
  for (const MarkerGaps* gaps : long_ones) longest = std::max(longest, gaps->longest);
  if (long_ones.size() > most_sentences) {
    doubts.push_back(count_of(long_ones.size(), "marker") + " of " +
                     std::to_string(result.gaps.size()) +
                     " are missing in more than 20 % of the frames, up to " +
                     format_fixed(seconds(result, longest), 1) +
                     " s at a time: the chart of the gaps shows which");
    return;
  }
  for (const MarkerGaps* gaps : long_ones) {
    doubts.push_back("marker '" + label_of(result.markers[gaps->marker]) + "' is missing in " +
                     format_fixed(gaps->missing_percent, 0) + " % of the frames, up to " +
                     format_fixed(seconds(result, gaps->longest), 1) + " s at a time");
  }
}

std::string frames_text(const ConvertResult& result, const FrameRange& frames) {
  const int64_t first = result.animation.first_frame;
  const std::string begin = std::to_string(first + static_cast<int64_t>(frames.begin));
  if (frames.end - frames.begin == 1) return "frame " + begin;
  return "frames " + begin + " to " + std::to_string(first + static_cast<int64_t>(frames.end) - 1);
}

/// Stretches in which nothing at all was measured.
void doubt_blind_stretches(const ConvertResult& result, std::vector<std::string>& doubts) {
  std::vector<std::size_t> missing(result.animation.frame_count() + 1, 0);
  for (const MarkerGaps& gaps : result.gaps) {
    for (const FrameRange& gap : gaps.gaps) {
      for (std::size_t f = gap.begin; f < gap.end; ++f) ++missing[f];
    }
  }
  std::vector<FrameRange> blind;
  for (std::size_t f = 0; f + 1 < missing.size(); ++f) {
    if (result.gaps.empty() || missing[f] < result.gaps.size()) continue;
    if (blind.empty() || blind.back().end != f) blind.push_back({f, f});
    blind.back().end = f + 1;
  }
  if (blind.empty()) return;
  const auto longest = std::ranges::max_element(blind, {}, &FrameRange::size);
  doubts.push_back("no marker at all is seen in " + frames_text(result, *longest) + " (" +
                   format_fixed(seconds(result, longest->size()), 2) + " s)" +
                   (blind.size() > 1 ? " and in " + count_of(blind.size() - 1, "other stretch",
                                                             "other stretches")
                                     : "") +
                   ": the mesh is a guess there");
}

void doubt_estimates(const ConvertResult& result, std::vector<std::string>& doubts) {
  std::vector<const Fill*> rough;
  for (const Fill& fill : result.fills) {
    if (fill.mean_sd_mm > 1.0) rough.push_back(&fill);
  }
  if (rough.empty()) return;
  if (rough.size() > most_sentences) {
    const Fill& worst = **std::ranges::max_element(rough, {}, &Fill::mean_sd_mm);
    doubts.push_back(count_of(rough.size(), "gap") +
                     " are estimated with an uncertainty of more than 1 mm, the worst is marker '" +
                     label_of(result.markers[worst.marker]) + "', " +
                     frames_text(result, worst.frames) + ": " + format_fixed(worst.mean_sd_mm, 1) +
                     " mm");
    return;
  }
  for (const Fill* fill : rough) {
    doubts.push_back("marker '" + label_of(result.markers[fill->marker]) + "', " +
                     frames_text(result, fill->frames) + ": estimated with an uncertainty of " +
                     format_fixed(fill->mean_sd_mm, 1) + " mm");
  }
}

/// Both eyes carry about as many markers; a ring of half as many as the other's is half an eye.
void doubt_uneven_eyes(const ConvertResult& result, std::vector<std::string>& doubts) {
  const Opening* eyes[2] = {nullptr, nullptr};
  for (const Opening& opening : result.triangulation.openings) {
    if (opening.name == OpeningName::left_eye) eyes[0] = &opening;
    if (opening.name == OpeningName::right_eye) eyes[1] = &opening;
  }
  if (eyes[0] == nullptr || eyes[1] == nullptr) return;
  if (eyes[0]->loop.size() > eyes[1]->loop.size()) std::swap(eyes[0], eyes[1]);
  const std::size_t fewer = eyes[0]->loop.size();
  const std::size_t more = eyes[1]->loop.size();
  if (3 * fewer >= 2 * more) return;
  doubts.push_back("the ring of the " + std::string(name_of(eyes[0]->name)) + " has only " +
                   count_of(fewer, "marker") + ", that of the other eye " + std::to_string(more) +
                   ": it may be half open. Look at the picture; --" +
                   (eyes[0]->name == OpeningName::left_eye ? "left" : "right") +
                   "-eye closed leaves it out");
}

void doubt_forced_openings(const ConvertResult& result, std::vector<std::string>& doubts) {
  for (const Opening& opening : result.triangulation.openings) {
    if (!opening.forced || opening.score >= threshold_of(opening)) continue;
    doubts.push_back(
        "the " + std::string(name_of(opening.name)) +
        " is open as asked for, although the motion hardly shows it (score " +
        format_fixed(opening.score, 2) + ", by itself from " +
        format_fixed(threshold_of(opening), 2) +
        "): check that its ring is the right one: " + join(labels_of(opening, result), ", "));
  }
}

}  // namespace

FillUncertainty uncertainty_of(const ConvertResult& result, std::size_t vertex) {
  FillUncertainty sum;
  for (const Fill& fill : result.fills) {
    if (fill.marker != vertex) continue;
    sum.frames += fill.frames.size();
    sum.mean_mm += fill.mean_sd_mm * static_cast<double>(fill.frames.size());
    sum.max_mm = std::max(sum.max_mm, fill.max_sd_mm);
  }
  if (sum.frames > 0) sum.mean_mm /= static_cast<double>(sum.frames);
  return sum;
}

std::vector<std::string> doubts_of(const ConvertResult& result) {
  std::vector<std::string> doubts = result.warnings;
  doubt_blind_stretches(result, doubts);
  doubt_missing(result, doubts);
  doubt_estimates(result, doubts);
  doubt_forced_openings(result, doubts);
  doubt_uneven_eyes(result, doubts);
  if (result.summary.frames_with_flips > 0) {
    doubts.push_back(count_of(result.summary.frames_with_flips, "frame") + " of " +
                     std::to_string(result.animation.frame_count()) +
                     " with flipped triangles, most in frame " +
                     std::to_string(result.animation.first_frame +
                                    static_cast<int64_t>(result.summary.worst_frame)) +
                     " (" + std::to_string(result.summary.worst_count) +
                     "): look there for swapped or jumping markers" + suspects_text(result));
  }
  return doubts;
}

std::string summary_text(const MarkerSequence& session, const ConvertResult& result) {
  const AnimatedMesh& mesh = result.animation;
  const std::string left_out = left_out_text(result.selection);
  std::string text;
  const auto line = [&text](const std::string& key, const std::string& value) {
    text += key + std::string(key.size() < 12 ? 12 - key.size() : 1, ' ') + value + "\n";
  };
  line("session", session.origin.path + ": " + count_of(session.marker_count(), "point") + ", " +
                      count_of(mesh.frame_count(), "frame") + " at " + format_number(mesh.rate_hz) +
                      " Hz (" + format_fixed(mesh.duration_s(), 1) + " s)");
  line("markers", std::to_string(result.markers.size()) + " chosen" +
                      (left_out.empty() ? "" : "; left out: " + left_out));
  if (!result.rigid.empty()) {
    line("head", "motion removed with " + join(result.rigid, ", ") + "; error " +
                     format_fixed(result.head_error_mm, 2) + " mm (RMS)");
  }
  line("gaps", result.fills.empty()
                   ? "none"
                   : count_of(result.fills.size(), "gap") + " filled, " +
                         format_fixed(100.0 * static_cast<double>(filled_frames(result)) /
                                          static_cast<double>(
                                              std::max<std::size_t>(result.summary.samples, 1)),
                                      2) +
                         " % of all samples");
  line("mesh", count_of(mesh.topology().vertex_count(), "vertex", "vertices") + ", " +
                   count_of(mesh.topology().face_count(), "triangle") + ", made from frame " +
                   std::to_string(result.triangulation.frame_number) + ", markers " +
                   format_fixed(result.triangulation.diagnostics.spacing, 1) + " mm apart");
  line("openings", openings_text(result));
  const std::vector<std::string> doubts = doubts_of(result);
  for (std::size_t i = 0; i < doubts.size(); ++i) line(i == 0 ? "doubtful" : "", doubts[i]);
  return text;
}

std::string summary_json(const MarkerSequence& session, const ConvertResult& result,
                         const WrittenMesh& written) {
  const AnimatedMesh& mesh = result.animation;
  Json inputs = Json::array();
  for (const Provenance::Input& input : mesh.provenance.inputs) {
    inputs.push_back({{"path", input.path}, {"sha256", input.sha256}});
  }
  const Json document = {{"program", mesh.provenance.program},
                         {"command", mesh.provenance.command},
                         {"inputs", std::move(inputs)},
                         {"session",
                          {{"points", session.marker_count()},
                           {"frames", mesh.frame_count()},
                           {"first_frame", mesh.first_frame},
                           {"rate_hz", mesh.rate_hz},
                           {"duration_s", mesh.duration_s()},
                           {"unit", session.origin.unit},
                           {"written_by", session.origin.manufacturer}}},
                         {"markers", gaps_json(result)},
                         {"left_out", left_out_json(session, result.selection)},
                         {"head",
                          {{"stabilised", !result.head_poses.empty()},
                           {"rigid_markers", result.rigid},
                           {"error_mm", result.head_error_mm}}},
                         {"mesh", mesh_json(result)},
                         {"quality", quality_json(result)},
                         {"doubtful", doubts_of(result)},
                         {"written",
                          {{"format", written.format},
                           {"mesh_files", written.mesh_files},
                           {"not_kept", written.lost},
                           {"max_error_mm", written.max_error_mm},
                           {"rms_error_mm", written.rms_error_mm}}},
                         {"outputs", written.outputs},
                         {"options", mesh.provenance.options}};
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string quality_csv(const ConvertResult& result) {
  const std::vector<double> uncertainty = largest_uncertainty(result.animation);
  std::string text =
      "frame,time_s,flipped,degenerate,stretch_min,stretch_max,stretch_rms,filled,"
      "uncertainty_max_mm,head_error_mm\n";
  for (std::size_t f = 0; f < result.quality.size(); ++f) {
    const FrameQuality& q = result.quality[f];
    text += std::to_string(result.animation.first_frame + static_cast<int64_t>(f)) + "," +
            format_number(result.animation.time_s(f)) + "," + std::to_string(q.flipped) + "," +
            std::to_string(q.degenerate) + "," + format_fixed(q.stretch_min, 4) + "," +
            format_fixed(q.stretch_max, 4) + "," + format_fixed(q.stretch_rms, 4) + "," +
            std::to_string(q.filled) + "," +
            (uncertainty.empty() ? "0" : format_fixed(uncertainty[f], 4)) + ",";
    const bool head = !result.head_poses.empty() && !std::isnan(result.head_poses[f].error_mm);
    text += (head ? format_fixed(result.head_poses[f].error_mm, 4) : "") + "\n";
  }
  return text;
}

std::vector<double> largest_uncertainty(const AnimatedMesh& mesh) {
  std::vector<double> largest;
  const std::size_t vertices = mesh.vertex_count();
  for (std::size_t i = 0; i < mesh.uncertainty().size(); i += vertices) {
    largest.push_back(std::ranges::max(mesh.uncertainty().subspan(i, vertices)));
  }
  return largest;
}

GapChart gap_chart_of(const ConvertResult& result) {
  GapChart chart;
  chart.frame_count = result.animation.frame_count();
  chart.rate_hz = result.animation.rate_hz;
  chart.first_frame = result.animation.first_frame;
  for (const Marker& marker : result.markers) chart.markers.push_back({marker.label, {}});
  for (const Fill& fill : result.fills) {
    const bool spline = fill.method == FillMethod::linear || fill.method == FillMethod::cubic ||
                        fill.method == FillMethod::quintic;
    chart.markers[fill.marker].gaps.push_back(
        {fill.frames.begin, fill.frames.end, spline ? 1U : 2U});
  }
  return chart;
}

}  // namespace kinemesh
