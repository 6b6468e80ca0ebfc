#include "capture/clean_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "capture/edit/operation.h"
#include "capture/gaps.h"
#include "capture/stabilise.h"
#include "config/error.h"
#include "config/text.h"
#include "report/chart.h"
#include "report/gap_chart.h"

namespace kinemesh {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double page_width = 1400.0;
constexpr double margin = 16.0;
constexpr double chart_height = 230.0;

/// Seconds (or frames, without a rate) since recorded frame 1: the axis of both takes.
double time_of(const MarkerSequence& take, std::size_t f) {
  const auto frame = static_cast<double>(take.first_frame - 1) + static_cast<double>(f);
  return take.rate_hz > 0 ? frame / take.rate_hz : frame + 1.0;
}

Axis time_axis(const MarkerSequence& take) {
  return take.rate_hz > 0 ? Axis{.label = "time", .unit = "s"}
                          : Axis{.label = "frame", .integer = true};
}

std::size_t same_marker(const MarkerSequence& take, const Marker& marker) {
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const Marker& other = take.markers()[m];
    if (other.label == marker.label && other.subject == marker.subject) return m;
  }
  return take.find(marker.label);
}

/// Both takes frame by frame, the earlier one with the markers of the later.
struct Pair {
  const MarkerSequence& before;
  const MarkerSequence& after;
  std::vector<std::size_t> column;  ///< in `before`, per marker of `after`; npos for none
  bool same_frames = false;

  /// 0-based frame of `before` that frame f of `after` was; nothing when the take was cut, joined
  /// or sampled anew.
  std::optional<std::size_t> frame(std::size_t f) const {
    return same_frames ? std::optional(f) : std::nullopt;
  }
};

Pair pair_of(const MarkerSequence& before, const MarkerSequence& after) {
  Pair pair{before, after, {}, false};
  for (const Marker& marker : after.markers()) pair.column.push_back(same_marker(before, marker));
  pair.same_frames = before.rate_hz == after.rate_hz && before.frame_count() == after.frame_count();
  return pair;
}

// ---- gaps ---------------------------------------------------------------------------------------

/// How far the sample was moved, or taken out: the repairs, without the small steps of a filter.
double moved(const Pair& pair, std::size_t f, std::size_t m) {
  constexpr double least_mm = 1.0;
  const std::size_t column = pair.column[m];
  const std::optional<std::size_t> was = pair.frame(f);
  if (column == MarkerSequence::npos || !was) return 0.0;
  if (!pair.before.valid(*was, column) || !pair.after.valid(f, m)) return 0.0;
  const double mm = (pair.after.position(f, m) - pair.before.position(*was, column)).norm();
  return mm > least_mm ? mm : 0.0;
}

/// In other axes or another place altogether nothing can be laid over each other.
bool comparable(const Pair& pair) {
  constexpr double elsewhere_mm = 20.0;
  std::size_t shared = 0, far = 0;
  for (std::size_t f = 0; f < pair.after.frame_count(); f += 1 + pair.after.frame_count() / 50) {
    for (std::size_t m = 0; m < pair.after.marker_count(); ++m) {
      const std::size_t column = pair.column[m];
      const std::optional<std::size_t> was = pair.frame(f);
      if (column == MarkerSequence::npos || !was) continue;
      if (!pair.before.valid(*was, column) || !pair.after.valid(f, m)) continue;
      ++shared;
      if (moved(pair, f, m) > elsewhere_mm) ++far;
    }
  }
  return shared > 0 && 2 * far < shared;
}

/// The kinds of default_gap_styles(), and one more.
enum : std::size_t { missing = 0, estimated = 2, repaired = 3, relabelled = 4 };

/// Measured samples that are at another place than they were, as after labels were exchanged.
std::vector<GapInterval> moved_intervals(const Pair& pair, std::size_t marker) {
  std::vector<GapInterval> out;
  for (std::size_t f = 0; f < pair.after.frame_count(); ++f) {
    if (pair.after.filled(f, marker) || moved(pair, f, marker) == 0.0) continue;
    if (!out.empty() && out.back().end == f) {
      ++out.back().end;
    } else {
      out.push_back({f, f + 1, relabelled});
    }
  }
  return out;
}

std::vector<GapInterval> intervals(const MarkerSequence& take, std::size_t marker,
                                   const Pair* pair) {
  std::vector<GapInterval> out;
  for (const FrameRange gap : find_gaps(take, marker).gaps) {
    // Frames of one gap differ: filled, left open, or a spike that was taken out.
    const auto kind_at = [&](std::size_t f) -> std::size_t {
      if (!take.valid(f, marker)) return missing;
      if (pair == nullptr || pair->column[marker] == MarkerSequence::npos) return estimated;
      const std::optional<std::size_t> was = pair->frame(f);
      return was && pair->before.valid(*was, pair->column[marker]) ? repaired : estimated;
    };
    for (std::size_t f = gap.begin; f < gap.end;) {
      GapInterval interval{f, f, kind_at(f)};
      while (interval.end < gap.end && kind_at(interval.end) == interval.kind) ++interval.end;
      out.push_back(interval);
      f = interval.end;
    }
  }
  return out;
}

GapChart empty_chart(const MarkerSequence& take, const std::string& title) {
  GapChart chart;
  chart.title = title;
  chart.frame_count = take.frame_count();
  chart.rate_hz = take.rate_hz;
  chart.first_frame = take.first_frame;
  chart.order = GapChart::Order::as_given;
  chart.kinds.push_back({"moved by over 1 mm", series_colour(4), true});
  return chart;
}

/// The same markers in the same rows of both charts, the ones missing most first.
std::pair<GapChart, GapChart> gap_charts(const Pair& pair) {
  const bool both = comparable(pair);
  constexpr std::size_t most_rows = 60;
  struct Row {
    std::string label;
    std::vector<GapInterval> before, after;
    std::size_t frames = 0;
  };
  std::vector<Row> rows;
  for (std::size_t m = 0; m < pair.after.marker_count(); ++m) {
    if (pair.after.markers()[m].kind != MarkerKind::marker) continue;
    Row row{pair.after.markers()[m].label, {}, intervals(pair.after, m, &pair)};
    if (pair.column[m] != MarkerSequence::npos) {
      row.before = intervals(pair.before, pair.column[m], nullptr);
    }
    if (both) {
      const std::vector<GapInterval> elsewhere = moved_intervals(pair, m);
      row.after.insert(row.after.end(), elsewhere.begin(), elsewhere.end());
      std::ranges::sort(row.after, {}, &GapInterval::begin);
    }
    for (const auto* list : {&row.before, &row.after}) {
      for (const GapInterval& gap : *list) row.frames += gap.end - gap.begin;
    }
    if (row.frames > 0) rows.push_back(std::move(row));
  }
  std::ranges::stable_sort(rows, std::greater{}, &Row::frames);
  const std::size_t shown = std::min(rows.size(), most_rows);
  std::pair charts{
      empty_chart(pair.before, "Before"),
      empty_chart(pair.after, pair.same_frames ? "After" : "After, by its own frames")};
  const std::string which =
      rows.empty() ? "nothing was missing, nothing was repaired"
                   : count_of(rows.size(), "marker") + " with gaps or repairs" +
                         (shown < rows.size() ? ", the first " + std::to_string(shown) : "");
  charts.first.subtitle = charts.second.subtitle = which;
  for (std::size_t i = 0; i < shown; ++i) {
    charts.first.markers.push_back({rows[i].label, rows[i].before});
    charts.second.markers.push_back({rows[i].label, rows[i].after});
  }
  return charts;
}

// ---- trajectories -------------------------------------------------------------------------------

/// A stretch of one marker that is worth a chart.
struct Change {
  std::size_t marker = 0;  ///< in `after`
  std::size_t frame = 0;   ///< where it is worst
  double mm = 0.0;
};

/// The worst frame of every marker by `size`, the worst markers first.
template <class Size>
std::vector<Change> worst_of(const MarkerSequence& take, Size&& size) {
  std::vector<Change> worst;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind != MarkerKind::marker) continue;
    Change change{m, 0, 0.0};
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      const double mm = size(f, m);
      if (mm > change.mm) change = {m, f, mm};
    }
    if (change.mm > 0.0) worst.push_back(change);
  }
  std::ranges::stable_sort(worst, std::greater{}, &Change::mm);
  return worst;
}

/// The coordinate that moves most over the window.
int telling_axis(const MarkerSequence& take, std::size_t marker, FrameRange window) {
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::max());
  Eigen::Array3f high = -low;
  for (std::size_t f = window.begin; f < window.end; ++f) {
    if (!take.valid(f, marker)) continue;
    low = low.min(take.position(f, marker).array());
    high = high.max(take.position(f, marker).array());
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  return axis;
}

Series curve(const std::string& label, Colour colour) {
  Series series{.label = label};
  series.colour = colour;
  return series;
}

LineChart trajectory_chart(const Pair& pair, const Change& change, const std::string& what) {
  constexpr double window_s = 1.0;
  constexpr double one_coordinate_90 = 1.6449;  // 90 % of a normal distribution
  const MarkerSequence& take = pair.after;
  const double rate = take.rate_hz > 0 ? take.rate_hz : 60.0;
  const auto half = static_cast<std::size_t>(std::ceil(window_s * rate));
  FrameRange window{change.frame > half ? change.frame - half : 0,
                    std::min(take.frame_count(), change.frame + half + 1)};
  // A longer gap is shown whole.
  while (window.begin > 0 && take.filled(window.begin, change.marker)) --window.begin;
  while (window.end < take.frame_count() && take.filled(window.end - 1, change.marker))
    ++window.end;
  const int axis = telling_axis(take, change.marker, window);
  Series before = curve("before", colour_from_hex(0xf0a8a0));
  before.width = 4.0;
  Series after = curve("after", series_colour(0));
  Series low = curve("90 % band of what is estimated", filled_colour);
  Series high = curve("", filled_colour);
  low.dashed = high.dashed = true;
  const std::size_t column = pair.column[change.marker];
  for (std::size_t f = window.begin; f < window.end; ++f) {
    const double t = time_of(take, f);
    const std::optional<std::size_t> was = pair.frame(f);
    const bool seen = was && column != MarkerSequence::npos && pair.before.valid(*was, column);
    const bool valid = take.valid(f, change.marker);
    const double y = valid ? double{take.position(f, change.marker)[axis]} : nothing;
    const bool band = take.filled(f, change.marker) && !take.uncertainty().empty();
    const double sd = band ? double{take.uncertainty()[take.sample(f, change.marker)]} : nothing;
    for (Series* s : {&before, &after, &low, &high}) s->x.push_back(t);
    before.y.push_back(seen ? double{pair.before.position(*was, column)[axis]} : nothing);
    after.y.push_back(y);
    low.y.push_back(y - one_coordinate_90 * sd);
    high.y.push_back(y + one_coordinate_90 * sd);
  }
  LineChart chart{.title = take.markers()[change.marker].label + ": " + what,
                  .x = time_axis(take),
                  .y = {.label = std::string(1, "xyz"[axis]), .unit = "mm"}};
  const auto shown = [](double v) { return std::isfinite(v); };
  if (std::ranges::any_of(before.y, shown)) chart.series.push_back(std::move(before));
  chart.series.push_back(std::move(after));
  if (std::ranges::any_of(low.y, shown)) {
    chart.series.push_back(std::move(low));
    chart.series.push_back(std::move(high));
  }
  return chart;
}

/// Whether the chart of another change shows this one with its band.
auto shows(const Change& change, double rate_hz) {
  return [&change, apart = 0.5 * rate_hz](const Change& other) {
    const double frames = static_cast<double>(change.frame) - static_cast<double>(other.frame);
    return change.marker == other.marker && std::abs(frames) <= apart;
  };
}

std::vector<LineChart> trajectory_charts(const Pair& pair) {
  constexpr std::size_t most = 3;
  std::vector<LineChart> charts;
  std::vector<Change> drawn;
  const bool both = comparable(pair);
  if (both) {
    const auto changes =
        worst_of(pair.after, [&](std::size_t f, std::size_t m) { return moved(pair, f, m); });
    for (std::size_t i = 0; i < std::min(most, changes.size()); ++i) {
      charts.push_back(
          trajectory_chart(pair, changes[i], "moved by " + format_fixed(changes[i].mm, 1) + " mm"));
      drawn.push_back(changes[i]);
    }
  }
  if (pair.after.uncertainty().empty()) return charts;
  const auto rough = worst_of(pair.after, [&](std::size_t f, std::size_t m) {
    return pair.after.filled(f, m) ? double{pair.after.uncertainty()[pair.after.sample(f, m)]}
                                   : 0.0;
  });
  const Pair alone{pair.before, pair.after,
                   std::vector<std::size_t>(pair.column.size(), MarkerSequence::npos), false};
  for (std::size_t i = 0, more = 0; i < rough.size() && more < most; ++i) {
    if (std::ranges::any_of(drawn, shows(rough[i], pair.after.rate_hz))) continue;
    charts.push_back(
        trajectory_chart(both ? pair : alone, rough[i],
                         "estimated, uncertain by up to " + format_fixed(rough[i].mm, 2) + " mm"));
    ++more;
  }
  return charts;
}

// ---- the head -----------------------------------------------------------------------------------

/// The options of the last step that stabilises; nothing when none does.
std::optional<StabiliseOptions> stabilising(const EditList& edits) {
  std::optional<StabiliseOptions> found;
  for (const auto& step : edits.steps) {
    if (step->name() != "stabilise") continue;
    auto& bound = const_cast<EditOperation&>(*step);  // NOLINT(*-const-cast): only read here
    ParameterSet given, own;
    found.emplace();
    bound.declare(given);
    found->declare(own);
    for (const Parameter& p : given.parameters()) own.find(p.name())->set(p.get());
  }
  return found;
}

/// Per frame the RMS distance of these markers from their mean place.
Series motion_of(const MarkerSequence& take, const std::vector<Marker>& markers) {
  Series series;
  std::vector<std::size_t> columns;
  for (const Marker& marker : markers) {
    const std::size_t m = same_marker(take, marker);
    if (m != MarkerSequence::npos) columns.push_back(m);
  }
  const auto measured = [&](std::size_t f, std::size_t m) {
    return take.valid(f, m) && !take.filled(f, m);
  };
  std::vector<Eigen::Vector3d> means;
  for (const std::size_t m : columns) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (!measured(f, m)) continue;
      sum += take.position(f, m).cast<double>();
      count += 1.0;
    }
    means.emplace_back(sum / std::max(1.0, count));
  }
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (!measured(f, columns[k])) continue;
      squares += (take.position(f, columns[k]).cast<double>() - means[k]).squaredNorm();
      count += 1.0;
    }
    series.x.push_back(time_of(take, f));
    series.y.push_back(count > 0.0 ? std::sqrt(squares / count) : nothing);
  }
  return series;
}

std::vector<LineChart> head_charts(const MarkerSequence& before, const MarkerSequence& after,
                                   const StabiliseResult& steady) {
  std::vector<Marker> markers;
  std::vector<std::string> labels;
  for (const std::size_t m : steady.shape.markers) {
    markers.push_back(before.markers()[m]);
    labels.push_back(before.markers()[m].label);
  }
  std::vector<LineChart> charts;
  for (const bool done : {false, true}) {
    const MarkerSequence& take = done ? after : before;
    const std::string title = done ? "Head after stabilising, error per frame"
                                   : "Head before stabilising, motion per frame";
    LineChart chart{.title = title + " (rigid markers, RMS)",
                    .x = time_axis(take),
                    .y = {.label = "from mean place", .unit = "mm", .from_zero = true}};
    chart.series = {motion_of(take, markers)};
    chart.series.back().label = join(labels, ", ");
    chart.series.back().colour = series_colour(done ? 0 : 1);
    charts.push_back(std::move(chart));
  }
  return charts;
}

// ---- the page -----------------------------------------------------------------------------------

void draw_gaps(const std::pair<GapChart, GapChart>& charts, double y, Canvas& page) {
  const double half = 0.5 * page.width() - 1.5 * margin;
  double x = margin;
  for (const GapChart* chart : {&charts.first, &charts.second}) {
    const Canvas drawn = draw_gap_chart(*chart, half);
    page.image({x, y, drawn.width(), drawn.height()}, drawn.raster(png_scale(drawn)));
    x += half + margin;
  }
}

}  // namespace

Canvas draw_cleaning(const MarkerSequence& before, const MarkerSequence& after,
                     const EditList& edits, const std::string& title, const RunContext& ctx) {
  std::vector<LineChart> charts;
  std::optional<StabiliseResult> steady;
  if (const auto options = stabilising(edits)) {
    try {
      steady = stabilise_head(before, *options, RunContext().set_threads(ctx.threads()));
      charts = head_charts(before, after, *steady);
    } catch (const Error&) {  // an earlier step of the list made the head's markers
    }
  }
  const Pair pair = pair_of(steady ? steady->take : before, after);
  const auto gaps = gap_charts(pair);
  const auto trajectories = trajectory_charts(pair);
  charts.insert(charts.end(), trajectories.begin(), trajectories.end());
  const double gaps_height = draw_gap_chart(gaps.first, 0.5 * page_width - 1.5 * margin).height();
  const double charts_top = 56.0 + gaps_height + margin;
  const double rows = std::ceil(0.5 * static_cast<double>(charts.size()));
  Canvas page(page_width, charts_top + rows * (chart_height + margin));
  page.text_within({margin, 34.0}, "What was done to " + title, page_width - 2.0 * margin,
                   {.size = 20.0, .bold = true});
  if (gaps.first.markers.empty() && charts.empty()) {
    page.text({margin, 52.0}, "Nothing was missing, nothing was repaired.", {.size = 13.0});
  }
  draw_gaps(gaps, 56.0, page);
  const double half = 0.5 * page_width - 1.5 * margin;
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const double x = i % 2 == 0 ? margin : 2.0 * margin + half;
    const double y =
        charts_top + std::floor(0.5 * static_cast<double>(i)) * (chart_height + margin);
    charts[i].draw(page, {x, y, half, chart_height});
  }
  return page;
}

}  // namespace kinemesh
