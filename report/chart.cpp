#include "report/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/text.h"
#include "report/chart_axes.h"

namespace kinemesh {
namespace {

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

std::vector<LegendEntry> legend_of(const LineChart& chart) {
  std::vector<LegendEntry> entries;
  for (const Series& s : chart.series) {
    if (s.label.empty()) continue;
    const auto symbol = s.dots     ? LegendEntry::Symbol::dot
                        : s.dashed ? LegendEntry::Symbol::dashed_line
                                   : LegendEntry::Symbol::line;
    entries.push_back({s.label, s.colour, symbol});
  }
  for (const LineChart::Band& band : chart.bands) {
    const bool known = std::any_of(entries.begin(), entries.end(),
                                   [&](const LegendEntry& e) { return e.label == band.label; });
    if (!band.label.empty() && !known) {
      entries.push_back({band.label, band.colour, LegendEntry::Symbol::box});
    }
  }
  if (entries.size() == 1 && chart.bands.empty()) entries.clear();  // the axis says it
  return entries;
}

// At most four points per column of pixels: where the curve enters it, its lowest and highest
// value there, where it leaves.
class Thinned {
 public:
  explicit Thinned(Canvas& canvas, const Stroke& stroke) : canvas_(canvas), stroke_(stroke) {}
  void add(const Eigen::Vector2d& point) {
    const double column = std::floor(point.x());
    if (!open_ || column != column_) {
      flush_column();
      column_ = column;
      open_ = true;
      first_ = low_ = high_ = point;
    }
    if (point.y() < low_.y()) low_ = point;
    if (point.y() > high_.y()) high_ = point;
    last_ = point;
  }
  void interrupt() {
    flush_column();
    if (points_.size() == 1) points_.push_back(points_[0] + Eigen::Vector2d(0.8, 0.0));
    canvas_.polyline(std::move(points_), stroke_);
    points_.clear();
  }

 private:
  void flush_column() {
    if (!open_) return;
    open_ = false;
    const bool low_first = low_.x() <= high_.x();
    for (const Eigen::Vector2d& p :
         {first_, low_first ? low_ : high_, low_first ? high_ : low_, last_}) {
      if (points_.empty() || points_.back() != p) points_.push_back(p);
    }
  }

  Canvas& canvas_;
  const Stroke& stroke_;
  std::vector<Eigen::Vector2d> points_;
  Eigen::Vector2d first_, low_, high_, last_;
  double column_ = 0.0;
  bool open_ = false;
};

void draw_series(Canvas& canvas, const chart::Frame& frame, const Series& series) {
  const Stroke stroke{
      .colour = series.colour,
      .width = series.width,
      .dash = series.dashed ? std::vector<double>{5.0, 3.5} : std::vector<double>{}};
  Thinned line(canvas, stroke);
  const std::size_t count = std::min(series.x.size(), series.y.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
      line.interrupt();
      continue;
    }
    const Eigen::Vector2d at(frame.x(series.x[i]), frame.y(series.y[i]));
    if (series.dots) {
      canvas.circle(at, 1.6 * series.width, series.colour);
    } else {
      line.add(at);
    }
  }
  line.interrupt();
}

void draw_bands(Canvas& canvas, const chart::Frame& frame, const LineChart& chart) {
  for (const LineChart::Band& band : chart.bands) {
    const double from = std::clamp(frame.x(band.from), frame.plot.x, frame.plot.right());
    const double to = std::clamp(frame.x(band.to), frame.plot.x, frame.plot.right());
    canvas.rectangle({from, frame.plot.y, std::max(1.0, to - from), frame.plot.height},
                     band.colour);
  }
}

void draw_marks(Canvas& canvas, const chart::Frame& frame, const LineChart& chart) {
  const Stroke dashed{.colour = muted_colour, .width = 1.0, .dash = {4.0, 3.0}};
  const Box& plot = frame.plot;
  for (const LineChart::Mark& mark : chart.instants) {
    const double x = frame.x(mark.at);
    if (!(x >= plot.x && x <= plot.right())) continue;
    canvas.line({x, plot.y}, {x, plot.bottom()}, dashed);
    const bool left = x > plot.x + 0.75 * plot.width;
    canvas.text({x + (left ? -4.0 : 4.0), plot.y + 2.0}, mark.label,
                {.size = 10.0,
                 .colour = muted_colour,
                 .align = left ? TextAlign::right : TextAlign::left,
                 .anchor = TextAnchor::top});
  }
  for (const LineChart::Mark& mark : chart.levels) {
    const double y = frame.y(mark.at);
    if (!(y >= plot.y && y <= plot.bottom())) continue;
    canvas.line({plot.x, y}, {plot.right(), y}, dashed);
    canvas.text({plot.right() - 4.0, y - 3.0}, mark.label,
                {.size = 10.0, .colour = muted_colour, .align = TextAlign::right});
  }
}

}  // namespace

void LineChart::draw(Canvas& canvas, const Box& box) const {
  Box rest = chart::draw_title(canvas, box, title);
  const std::vector<LegendEntry> legend = legend_of(*this);
  if (!legend.empty()) {
    const double high = draw_legend(canvas, {rest.x + 8.0, rest.y}, rest.width - 16.0, legend);
    rest = rest.inset(0.0, high, 0.0, 0.0);
  }
  Extent xs;
  Extent ys;
  for (const Series& s : series) {
    for (const double value : s.x) xs.add(value);
    for (const double value : s.y) ys.add(value);
  }
  for (const Mark& mark : levels) ys.add(mark.at);
  const chart::Frame frame =
      chart::draw_axes(canvas, rest, x, chart::range_of(x, xs.low, xs.high, 0.0), y,
                       chart::range_of(y, ys.low, ys.high, 0.06));
  canvas.begin_clip(frame.plot.inset(0.0, -2.0, -2.0, -1.0));
  draw_bands(canvas, frame, *this);
  for (const Series& s : series) draw_series(canvas, frame, s);
  canvas.end_clip();
  draw_marks(canvas, frame, *this);
}

double BarChart::natural_height() const {
  return (title.empty() ? 6.0 : 28.0) + 20.0 * static_cast<double>(bars.size()) + 12.0 +
         chart::x_axis_height(value);
}

void BarChart::draw(Canvas& canvas, const Box& box) const {
  Box rest = chart::draw_title(canvas, box, title);
  Extent extent;
  extent.add(0.0);
  double labels = 20.0;
  double numbers = 20.0;
  for (const Bar& bar : bars) {
    extent.add(bar.value);
    labels = std::max(labels, text_width(bar.label, {.size = chart::label_size}));
    numbers =
        std::max(numbers, text_width(tick_label(bar.value, decimals), {.size = chart::label_size}));
  }
  labels = std::min(labels, 0.4 * box.width);
  const Box plot = rest.inset(labels + 14.0, 0.0, numbers + 16.0, chart::x_axis_height(value));
  const chart::Range range = chart::range_of(value, extent.low, extent.high, 0.0);
  const chart::Scale scale{range.low, range.high, plot.x, plot.right()};
  chart::draw_x_axis(canvas, plot, scale, value, true);
  const double step = plot.height / static_cast<double>(std::max<std::size_t>(bars.size(), 1));
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const Bar& bar = bars[i];
    const double y = plot.y + step * (static_cast<double>(i) + 0.5);
    canvas.text_within(
        {plot.x - 8.0, y}, bar.label, labels,
        {.size = chart::label_size, .align = TextAlign::right, .anchor = TextAnchor::middle});
    if (!std::isfinite(bar.value)) continue;
    const double from = std::clamp(scale(0.0), plot.x, plot.right());
    const double to = std::clamp(scale(bar.value), plot.x, plot.right());
    const double high = std::min(0.7 * step, 22.0);
    canvas.rectangle({std::min(from, to), y - 0.5 * high, std::abs(to - from), high}, bar.colour);
    canvas.text({std::max(from, to) + 6.0, y}, tick_label(bar.value, decimals),
                {.size = chart::label_size, .colour = muted_colour, .anchor = TextAnchor::middle});
  }
}

void Histogram::draw(Canvas& canvas, const Box& box) const {
  const Box rest = chart::draw_title(canvas, box, title);
  Extent extent;
  for (const double v : values) extent.add(v);
  const chart::Range range = chart::range_of(x, extent.low, extent.high, 0.0);
  // Bins begin at round numbers, so that the axis' numbers are their borders.
  const double step = nice_ticks(range.low, range.high, std::max(bins, 2), x.integer).step;
  const double first = std::floor(range.low / step) * step;
  const auto count =
      static_cast<std::size_t>(std::clamp(std::ceil((range.high - first) / step + 1e-9), 1.0, 1e4));
  std::vector<double> counts(count, 0.0);
  for (const double v : values) {
    if (!(v >= range.low && v <= range.high)) continue;
    const auto bin = static_cast<std::size_t>((v - first) / step + 1e-9);
    counts[std::min(bin, count - 1)] += 1.0;
  }
  const double most = *std::max_element(counts.begin(), counts.end());
  const Axis number{.label = "count", .from_zero = true, .integer = true};
  const chart::Frame frame =
      chart::draw_axes(canvas, rest, x, {first, first + step * static_cast<double>(count)}, number,
                       chart::range_of(number, 0.0, std::max(1.0, most), 0.06));
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    if (counts[i] == 0.0) continue;
    const double from = frame.x(first + step * static_cast<double>(i));
    const double to = frame.x(first + step * static_cast<double>(i + 1));
    const double top = frame.y(counts[i]);
    boxes.push_back({from + 0.5, top, std::max(1.0, to - from - 1.0), frame.plot.bottom() - top});
  }
  canvas.rectangles(std::move(boxes), colour);
}

void HeatStrip::draw(Canvas& canvas, const Box& box) const {
  Box rest = chart::draw_title(canvas, box, title);
  double labels = 8.0;
  for (const Row& row : rows) {
    labels = std::max(labels, text_width(row.label, {.size = chart::label_size}));
  }
  labels = std::min(labels, 0.3 * box.width) + 12.0;
  const Box plot = rest.inset(labels, 0.0, 84.0, chart::x_axis_height(x));
  const double high = plot.height / static_cast<double>(std::max<std::size_t>(rows.size(), 1));
  std::size_t most = 1;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    most = std::max(most, row.values.size());
    const double y = plot.y + high * static_cast<double>(r);
    canvas.text_within({plot.x - 6.0, y + 0.5 * high}, row.label, labels - 10.0,
                       {.size = std::min(chart::label_size, 0.9 * high),
                        .align = TextAlign::right,
                        .anchor = TextAnchor::middle});
    if (row.values.empty()) continue;
    Image colours(static_cast<int>(std::min<std::size_t>(row.values.size(), 1024)), 1);
    for (int i = 0; i < colours.width; ++i) {
      const std::size_t at =
          static_cast<std::size_t>(i) * row.values.size() / static_cast<std::size_t>(colours.width);
      const Colour c = scale(row.values[at]);
      uint8_t* pixel = colours.pixel(i, 0);
      pixel[0] = static_cast<uint8_t>(std::lround(255.0 * c.r));
      pixel[1] = static_cast<uint8_t>(std::lround(255.0 * c.g));
      pixel[2] = static_cast<uint8_t>(std::lround(255.0 * c.b));
    }
    const double space = high > 6.0 ? 1.0 : 0.0;
    canvas.image({plot.x, y, plot.width, high - space}, std::move(colours));
  }
  const chart::Scale across{x.low.value_or(0.0),
                            x.high.value_or(x.low.value_or(0.0) + static_cast<double>(most)),
                            plot.x, plot.right()};
  chart::draw_x_axis(canvas, plot, across, x, false);
  draw_colour_bar(canvas, {plot.right() + 16.0, plot.y, 16.0, std::max(60.0, plot.height)}, scale);
}

}  // namespace kinemesh
