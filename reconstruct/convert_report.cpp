#include "reconstruct/convert_report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "config/error.h"
#include "config/text.h"
#include "mesh/movement.h"
#include "reconstruct/convert_summary.h"
#include "report/camera.h"
#include "report/chart.h"
#include "report/gap_chart.h"
#include "report/html/components.h"
#include "report/html/mesh_viewer.h"

namespace kinemesh {
namespace {

std::string frame_number(const ConvertResult& result, std::size_t frame) {
  return std::to_string(result.animation.first_frame + static_cast<int64_t>(frame));
}

std::string seconds_text(const ConvertResult& result, std::size_t frames) {
  const double rate = result.animation.rate_hz;
  return rate > 0 ? format_fixed(static_cast<double>(frames) / rate, 2) : "";
}

std::string percent(double part, double whole, int decimals) {
  return format_fixed(whole > 0 ? 100.0 * part / whole : 0.0, decimals) + " %";
}

std::string take_text(const AnimatedMesh& mesh) {
  std::string text =
      count_of(mesh.vertex_count(), "marker") + " · " + count_of(mesh.frame_count(), "frame");
  if (mesh.rate_hz > 0) {
    text +=
        " at " + format_number(mesh.rate_hz) + " Hz · " + format_fixed(mesh.duration_s(), 1) + " s";
  }
  return text;
}

/// How far each vertex moves beside the motion of the head.
ViewerField movement_field(const AnimatedMesh& mesh, const RunContext& ctx) {
  ViewerField field;
  for (const double mm : movement_of(mesh, ctx)) {
    field.values.push_back(static_cast<float>(mm));
  }
  const float high = *std::ranges::max_element(field.values);
  field.scale = {ColourScale::Map::sequential, 0.0, high > 0 ? high : 1.0F, "movement, RMS", "mm"};
  return field;
}

Figures figures_of(const ConvertResult& result, std::size_t doubts) {
  const AnimatedMesh& mesh = result.animation;
  const CarrySummary& s = result.summary;
  Figures figures;
  figures.entries = {{std::to_string(mesh.vertex_count()), "markers"},
                     {std::to_string(mesh.topology().face_count()), "triangles"}};
  if (mesh.rate_hz > 0) {
    figures.entries.push_back(
        {format_fixed(mesh.duration_s(), 1) + " s", "at " + format_number(mesh.rate_hz) + " Hz"});
  } else {
    figures.entries.push_back({std::to_string(mesh.frame_count()), "frames"});
  }
  figures.entries.push_back({percent(static_cast<double>(s.samples - s.filled_samples),
                                     static_cast<double>(s.samples), 1),
                             "of the samples measured"});
  figures.entries.push_back({std::to_string(result.triangulation.openings.size()), "openings"});
  figures.entries.push_back({std::to_string(doubts), doubts == 1 ? "warning" : "warnings"});
  return figures;
}

/// At most `most` sentences; the rest is counted.
std::vector<std::string> shortened(std::vector<std::string> sentences, std::size_t most) {
  if (sentences.size() <= most) return sentences;
  const std::size_t rest = sentences.size() - most;
  sentences.resize(most);
  sentences.push_back("and " + std::to_string(rest) + " more, all in the summary (JSON)");
  return sentences;
}

std::vector<std::string> as_sentences(std::vector<std::string> texts) {
  for (std::string& text : texts) {
    if (!text.empty()) text.front() = upper(text.substr(0, 1)).front();
    text += '.';
  }
  return texts;
}

void add_session(HtmlPage& page, const MarkerSequence& session, const ConvertResult& result) {
  const AnimatedMesh& mesh = result.animation;
  KeyValues facts;
  for (const Provenance::Input& input : mesh.provenance.inputs) {
    facts.entries.emplace_back("file", input.path);
    facts.entries.emplace_back("SHA-256", input.sha256);
  }
  facts.entries.emplace_back("points", std::to_string(session.marker_count()));
  facts.entries.emplace_back(
      "frames", frame_number(result, 0) + " to " + frame_number(result, mesh.frame_count() - 1));
  facts.entries.emplace_back("rate",
                             mesh.rate_hz > 0 ? format_number(mesh.rate_hz) + " Hz" : "not given");
  facts.entries.emplace_back("unit of the file", session.origin.unit);
  if (!session.origin.manufacturer.empty()) {
    facts.entries.emplace_back("recorded with", session.origin.manufacturer);
  }
  HtmlSection& section = page.add_section("What came in").add(facts);
  Table left_out{"Points that are no vertices", {{"point"}, {"reason"}}, {}, true};
  for (std::size_t m = 0; m < result.selection.decisions.size(); ++m) {
    const MarkerDecision& decision = result.selection.decisions[m];
    if (!decision.chosen) left_out.rows.push_back({session.markers()[m].label, decision.text});
  }
  if (!left_out.rows.empty()) {
    left_out.caption += " (" + std::to_string(left_out.rows.size()) + ")";
    section.add(left_out);
  }
  Table events{"Events", {{"event"}, {"context"}, {"time (s)", true}}, {}, true};
  for (const Event& event : mesh.events) {
    events.rows.push_back({event.label, event.context, format_fixed(event.time_s, 3)});
  }
  if (!events.rows.empty()) section.add(events);
}

/// What filled a gap, as a reader of the report understands it.
std::string words_of(FillMethod method) {
  switch (method) {
    case FillMethod::automatic: return "other markers and time";
    case FillMethod::linear: return "straight line";
    case FillMethod::cubic: return "cubic spline";
    case FillMethod::quintic: return "quintic spline";
    case FillMethod::pattern: return "a donor marker";
    case FillMethod::rigid: return "rigid companions";
    case FillMethod::pca: return "correlations of markers";
    case FillMethod::hold: return "nearest position held";
  }
  return {};
}

/// A value per frame as a curve over the time (or the frame number, where the rate is not known).
Series over_time(const AnimatedMesh& mesh, const std::string& label, Colour colour,
                 std::vector<double> values) {
  Series series{label, {}, std::move(values)};
  series.colour = colour;
  for (std::size_t f = 0; f < series.y.size(); ++f) {
    series.x.push_back(mesh.rate_hz > 0
                           ? mesh.time_s(f)
                           : static_cast<double>(mesh.first_frame) + static_cast<double>(f));
  }
  return series;
}

Series over_time(const ConvertResult& result, const std::string& label, Colour colour,
                 double (*value)(const FrameQuality&)) {
  std::vector<double> values;
  for (const FrameQuality& q : result.quality) values.push_back(value(q));
  return over_time(result.animation, label, colour, std::move(values));
}

Axis time_axis(const ConvertResult& result) {
  return result.animation.rate_hz > 0 ? Axis{.label = "time", .unit = "s"}
                                      : Axis{.label = "frame", .integer = true};
}

LineChart uncertainty_chart(const ConvertResult& result) {
  const AnimatedMesh& mesh = result.animation;
  LineChart chart{.title = "Uncertainty of the estimated vertices",
                  .x = time_axis(result),
                  .y = {.label = "standard deviation", .unit = "mm", .from_zero = true}};
  std::vector<double> mean;
  const std::size_t vertices = mesh.vertex_count();
  for (std::size_t i = 0; i < mesh.uncertainty().size(); i += vertices) {
    double sum = 0.0;
    double count = 0.0;
    for (const float sd : mesh.uncertainty().subspan(i, vertices)) {
      sum += double{sd};
      count += sd > 0.0F ? 1.0 : 0.0;
    }
    mean.push_back(count > 0.0 ? sum / count : 0.0);
  }
  chart.series = {over_time(mesh, "largest", series_colour(0), largest_uncertainty(mesh)),
                  over_time(mesh, "mean of those estimated", series_colour(1), std::move(mean))};
  return chart;
}

/// Most uncertain markers first.
Table gap_table(const ConvertResult& result, std::size_t most) {
  std::vector<const MarkerGaps*> worst;
  for (const MarkerGaps& gaps : result.gaps) {
    if (gaps.missing > 0) worst.push_back(&gaps);
  }
  const auto most_uncertain = [&](const MarkerGaps* g) {
    return std::pair(uncertainty_of(result, g->marker).max_mm, g->missing);
  };
  std::ranges::stable_sort(worst, std::greater{}, most_uncertain);
  std::map<std::size_t, std::string> fills;  // methods
  for (const Fill& fill : result.fills) {
    std::string& methods = fills[fill.marker];
    const std::string name = words_of(fill.method);
    if (methods.find(name) == std::string::npos) methods += (methods.empty() ? "" : ", ") + name;
  }
  Table table{"Markers with gaps (" + std::to_string(worst.size()) + ")",
              {{"marker"},
               {"frames filled", true},
               {"share", true},
               {"gaps", true},
               {"longest (s)", true},
               {"filled by"},
               {"uncertainty, mean (mm)", true},
               {"largest (mm)", true}},
              {},
              true};
  for (std::size_t i = 0; i < std::min(worst.size(), most); ++i) {
    const MarkerGaps& gaps = *worst[i];
    const FillUncertainty uncertainty = uncertainty_of(result, gaps.marker);
    table.rows.push_back({result.markers[gaps.marker].label, std::to_string(uncertainty.frames),
                          format_fixed(gaps.missing_percent, 2) + " %",
                          std::to_string(gaps.gaps.size()), seconds_text(result, gaps.longest),
                          fills[gaps.marker], format_fixed(uncertainty.mean_mm, 2),
                          format_fixed(uncertainty.max_mm, 2)});
  }
  return table;
}

void add_gaps(HtmlPage& page, const ConvertResult& result, std::size_t most) {
  HtmlSection& section = page.add_section("Gaps");
  if (result.fills.empty()) {
    section.add(Paragraph{"Every marker was measured in every frame."});
    return;
  }
  GapChart chart = gap_chart_of(result);
  chart.title = "When which marker was not measured";
  std::erase_if(chart.markers, [](const GapChart::Row& row) { return row.gaps.empty(); });
  const std::size_t all = result.markers.size(), gapped = chart.markers.size();
  section.add(Figure{
      draw_gap_chart(chart, 1000.0), chart.title,
      gapped < all ? "The other " + count_of(all - gapped, "marker") + " were measured throughout."
                   : "",
      720.0});
  const LineChart chart_of_mm = uncertainty_chart(result);
  section.add(Figure{canvas_of(chart_of_mm, 1000.0, 240.0), chart_of_mm.title,
                     "Standard deviation of one coordinate; 90 % of the true places are within "
                     "2.5 times as much. Every file whose format has a place for it keeps the "
                     "value of every vertex in every frame.",
                     640.0});
  section.add(gap_table(result, most));
}

void add_quality(HtmlPage& page, const ConvertResult& result) {
  HtmlSection& section = page.add_section("Quality of each frame");
  LineChart stretch{.title = "Edge lengths over those of the reference frame",
                    .x = time_axis(result),
                    .y = {.label = "length ratio"},
                    .levels = {{1.0, ""}}};
  stretch.series = {over_time(result, "longest", series_colour(0),
                              [](const FrameQuality& q) { return double{q.stretch_max}; }),
                    over_time(result, "shortest", series_colour(1),
                              [](const FrameQuality& q) { return double{q.stretch_min}; }),
                    over_time(result, "1 + RMS", series_colour(2),
                              [](const FrameQuality& q) { return 1.0 + double{q.stretch_rms}; })};
  LineChart counts{.title = "Doubtful triangles and estimated vertices",
                   .x = time_axis(result),
                   .y = {.label = "number", .from_zero = true, .integer = true}};
  counts.series = {over_time(result, "flipped or degenerate triangles", missing_colour,
                             [](const FrameQuality& q) {
                               return static_cast<double>(q.flipped + q.degenerate);
                             }),
                   over_time(result, "estimated vertices", filled_colour,
                             [](const FrameQuality& q) { return static_cast<double>(q.filled); })};
  section.add(Paragraph{
      "A sudden peak in the edge lengths is a marker that jumped or was swapped with its "
      "neighbour; RMS is that of the relative changes of all edges; "
      "a flipped triangle is turned against the surface around it. The values of every frame are "
      "in the CSV file beside this report."});
  section.add(Figure{canvas_of(stretch, 1000.0, 260.0), stretch.title, "", 640.0});
  section.add(Figure{canvas_of(counts, 1000.0, 240.0), counts.title, "", 640.0});
}

/// How far the rigid markers are from their mean shape, frame by frame.
void add_head(HtmlPage& page, const ConvertResult& result) {
  if (result.head_poses.empty()) return;
  LineChart chart{.title = "Error of the head's pose",
                  .x = time_axis(result),
                  .y = {.label = "RMS of the rigid markers", .unit = "mm", .from_zero = true},
                  .levels = {{result.head_error_mm, "over the take"}}};
  std::vector<double> errors;
  std::size_t interpolated = 0;
  for (const HeadPose& pose : result.head_poses) {
    errors.push_back(pose.error_mm);
    interpolated += pose.interpolated ? 1 : 0;
  }
  chart.series = {over_time(result.animation, "error", series_colour(0), std::move(errors))};
  page.add_section("Head motion")
      .add(KeyValues{{{"removed with", join(result.rigid, ", ")},
                      {"error over the take", format_fixed(result.head_error_mm, 2) + " mm (RMS)"},
                      {"frames between measured poses", std::to_string(interpolated)}}})
      .add(Figure{canvas_of(chart, 1000.0, 240.0), chart.title,
                  interpolated > 0 ? "The curve is interrupted where too few rigid markers were "
                                     "seen: the pose is interpolated there."
                                   : "",
                  640.0});
}

void add_mesh(HtmlPage& page, const ConvertResult& result) {
  const Topology& topology = result.animation.topology();
  const TriangulateResult& t = result.triangulation;
  KeyValues facts;
  facts.entries = {
      {"vertices", std::to_string(topology.vertex_count())},
      {"triangles", std::to_string(topology.face_count())},
      {"reference frame", std::to_string(t.frame_number) +
                              (t.all_measured ? " (every marker measured)" : " (some filled)")},
      {"markers apart", format_fixed(t.diagnostics.spacing, 1) + " mm"},
      {"method", t.diagnostics.method},
      {"manifold", topology.is_manifold() ? "yes" : "no"}};
  if (!result.rigid.empty()) {
    facts.entries.emplace_back("head motion",
                               "removed with " + join(result.rigid, ", ") + "; error " +
                                   format_fixed(result.head_error_mm, 2) + " mm (RMS)");
  } else {
    facts.entries.emplace_back("head motion", "kept");
  }
  HtmlSection& section = page.add_section("Mesh").add(facts);
  Table openings{"Openings", {{"opening"}, {"found"}, {"markers", true}, {"score", true}}, {}};
  for (const Opening& o : t.openings) {
    openings.rows.push_back({std::string(name_of(o.name)), o.forced ? "asked for" : "by the motion",
                             std::to_string(o.loop.size()), format_fixed(o.score, 2)});
  }
  for (const OpeningCandidate& c : t.candidates) {
    if (c.opened) continue;
    openings.rows.push_back(
        {std::string(name_of(c.name)), "left closed: " + c.reason, "", format_fixed(c.score, 2)});
  }
  if (!openings.rows.empty()) section.add(openings);
}

void add_origin(HtmlPage& page, const ConvertResult& result,
                const std::vector<std::string>& outputs) {
  const Provenance& made = result.animation.provenance;
  HtmlSection& section = page.add_section("How it was made");
  section.add(KeyValues{{{"program", made.program}}});
  if (!made.command.empty()) section.add(CodeBlock{"Command that makes it again", made.command});
  if (!made.options.empty()) {
    section.add(CodeBlock{"All options (TOML, for --config)", made.options, true});
  }
  std::string hashes;
  for (const Provenance::Input& input : made.inputs) {
    hashes += input.sha256 + "  " + input.path + "\n";
  }
  if (!hashes.empty()) section.add(CodeBlock{"Inputs (SHA-256, for sha256sum -c)", hashes});
  if (!outputs.empty()) section.add(CodeBlock{"Files written", join(outputs, "\n") + "\n", true});
}

std::string exactness_text(const ConvertReportOptions& options) {
  if (options.mesh_max_error_mm <= 0.0) return "The exported mesh keeps every position.";
  return "The exported mesh is approximate: its error is at most " +
         format_fixed(options.mesh_max_error_mm, 4) + " mm, RMS " +
         format_fixed(options.mesh_rms_error_mm, 4) + " mm.";
}

std::string page_of(const MarkerSequence& session, const ConvertResult& result,
                    const ConvertReportOptions& options, const MeshViewer& viewer) {
  const std::vector<std::string> doubts = doubts_of(result);
  HtmlPage page(options.title.empty() ? "Converted session" : options.title,
                take_text(result.animation), result.animation.provenance.program);
  page.add_section("Look at this first")
      .add(WarningList{shortened(as_sentences(doubts), options.longest_list),
                       "Nothing doubtful was found in this take."})
      .add(figures_of(result, doubts.size()));
  page.add_section("Animated mesh")
      .add(viewer)
      .add(Paragraph{exactness_text(options), true})
      .add(Paragraph{"Movement is how far a vertex moves about its mean place (RMS over the take), "
                     "the motion of the whole head taken out.",
                     true});
  add_gaps(page, result, options.longest_list);
  add_quality(page, result);
  add_head(page, result);
  add_session(page, session, result);
  add_mesh(page, result);
  add_origin(page, result, options.outputs);
  return page.html();
}

}  // namespace

ConvertReport convert_report(const MarkerSequence& session, const ConvertResult& result,
                             const ConvertReportOptions& options, const RunContext& ctx) {
  const AnimatedMesh& mesh = result.animation;
  MeshViewerOptions view;
  if (options.up) view.axes = estimate_axes(mesh.topology(), mesh.frame(0), options.up);
  view.fields = {movement_field(mesh, ctx)};
  view.code.max_bytes = options.max_bytes * 3 / 5;
  // A browser adds up three million products a frame with ease: small meshes may have more modes.
  view.code.max_modes = std::max(view.code.max_modes, 1000000 / mesh.vertex_count());
  for (;;) {
    const MeshViewer viewer(mesh, view, ctx);
    ConvertReport report{page_of(session, result, options, viewer), viewer.code().max_error_mm,
                         viewer.code().rms_error_mm};
    if (report.html.size() <= options.max_bytes) return report;
    // Base64 makes 4 bytes of 3; what the page holds beside the animation is taken off its budget.
    const std::size_t excess = (report.html.size() - options.max_bytes) * 3 / 4 + 1024;
    const std::size_t used = std::min(view.code.max_bytes, viewer.code().bytes.size());
    if (used <= excess) {
      throw NoResultError({.what = "the report does not fit into " +
                                   std::to_string(options.max_bytes) +
                                   " bytes, even with the "
                                   "animation left out",
                           .remedy = "Write it without the report (--no-report)"});
    }
    view.code.max_bytes = used - excess;
  }
}

}  // namespace kinemesh
