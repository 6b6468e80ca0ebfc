#include "report/chart_axes.h"

#include <algorithm>
#include <cmath>

#include "config/text.h"

namespace kinemesh {

Ticks nice_ticks(double low, double high, int at_most, bool integer) {
  Ticks ticks;
  if (!std::isfinite(low) || !std::isfinite(high)) return ticks;
  const double span = high - low;
  if (!(span > 1e-290) || !std::isfinite(span)) {  // below, a tenth of it may be no number
    ticks.values = {low};
    return ticks;
  }
  at_most = std::max(at_most, 2);
  int exponent = static_cast<int>(std::floor(std::log10(span / at_most))) - 1;
  if (integer) exponent = std::max(exponent, 0);
  // A relative slack keeps limits that are themselves ticks in spite of rounding.
  const double slack = 1e-9;
  for (;; ++exponent) {
    for (const int factor : {1, 2, 5}) {
      const double step =
          exponent >= 0 ? factor * std::pow(10.0, exponent) : factor / std::pow(10.0, -exponent);
      const double first = std::ceil(low / step - slack);
      const double last = std::floor(high / step + slack);
      if (last - first + 1 > at_most) continue;
      ticks.step = step;
      ticks.decimals = std::max(0, -exponent);
      for (double k = first; k <= last; ++k) {
        ticks.values.push_back(exponent >= 0 ? k * step : k * factor / std::pow(10.0, -exponent));
      }
      return ticks;
    }
  }
}

std::string tick_label(double value, int decimals) {
  std::string digits = format_fixed(std::abs(value), decimals);
  const bool zero = digits.find_first_not_of("0.") == std::string::npos;
  const std::size_t whole = std::min(digits.find('.'), digits.size());
  if (whole > 4) {
    for (std::size_t at = whole; at > 3; at -= 3) {
      if (at - 3 > 0) digits.insert(at - 3, ",");
    }
  }
  return value < 0.0 && !zero ? "−" + digits : digits;
}

std::string with_unit(const std::string& label, const std::string& unit) {
  if (unit.empty()) return label;
  return label.empty() ? unit : label + " (" + unit + ")";
}

namespace chart {

Range range_of(const Axis& axis, double data_low, double data_high, double margin) {
  if (!(data_low <= data_high)) {
    data_low = axis.low.value_or(axis.high.value_or(1.0) - 1.0);
    data_high = data_low + 1.0;
  }
  double low = axis.low.value_or(axis.from_zero ? std::min(0.0, data_low) : data_low);
  double high = axis.high.value_or(axis.from_zero ? std::max(0.0, data_high) : data_high);
  const double room = margin * (high - low);
  if (!axis.low && !(axis.from_zero && low == 0.0)) low -= room;
  if (!axis.high && !(axis.from_zero && high == 0.0)) high += room;
  if (!(high > low)) {
    const double half = low == 0.0 ? 0.5 : 0.05 * std::abs(low);
    if (!axis.low && !(axis.from_zero && low == 0.0)) low -= half;
    high = std::max(high, low) + half;
  }
  return {low, high};
}

Box draw_title(Canvas& canvas, const Box& box, const std::string& title) {
  if (title.empty()) return box.inset(0, 6, 0, 0);
  canvas.text_within({box.x + 4, box.y + 6}, title, box.width - 8,
                     {.size = title_size, .bold = true, .anchor = TextAnchor::top});
  return box.inset(0, 28, 0, 0);
}

double x_axis_height(const Axis& axis) {
  return with_unit(axis.label, axis.unit).empty() ? 22.0 : 40.0;
}

void draw_x_axis(Canvas& canvas, const Box& plot, const Scale& scale, const Axis& axis, bool grid) {
  int count = std::max(2, static_cast<int>(plot.width / 70.0));
  Ticks ticks = nice_ticks(scale.low, scale.high, count, axis.integer);
  const TextStyle style{.size = label_size,
                        .colour = muted_colour,
                        .align = TextAlign::centre,
                        .anchor = TextAnchor::top};
  // Wide numbers need more room than the guess above allowed.
  double widest = 0.0;
  for (const double value : ticks.values) {
    widest = std::max(widest, text_width(tick_label(value, ticks.decimals), style));
  }
  if (widest + 12.0 > plot.width / count) {
    count = std::max(2, static_cast<int>(plot.width / (widest + 12.0)));
    ticks = nice_ticks(scale.low, scale.high, count, axis.integer);
  }
  std::vector<Eigen::Vector2d> ends;
  for (const double value : ticks.values) {
    const double x = scale(value);
    ends.emplace_back(x, grid ? plot.y : plot.bottom());
    ends.emplace_back(x, plot.bottom() + 4.0);
    canvas.text({x, plot.bottom() + 6.0}, tick_label(value, ticks.decimals), style);
  }
  canvas.lines(std::move(ends), {.colour = grid_colour});
  canvas.line({plot.x, plot.bottom()}, {plot.right(), plot.bottom()},
              {.colour = colour_from_hex(0x9aa4ae)});
  const std::string label = with_unit(axis.label, axis.unit);
  if (label.empty()) return;
  canvas.text({plot.x + 0.5 * plot.width, plot.bottom() + 22.0}, label,
              {.size = label_size, .align = TextAlign::centre, .anchor = TextAnchor::top});
}

Frame draw_axes(Canvas& canvas, const Box& box, const Axis& x, const Range& xs, const Axis& y,
                const Range& ys) {
  const double height = std::max(20.0, box.height - x_axis_height(x) - 10.0);
  const Ticks ticks =
      nice_ticks(ys.low, ys.high, std::max(2, static_cast<int>(height / 38.0)), y.integer);
  const TextStyle style{.size = label_size,
                        .colour = muted_colour,
                        .align = TextAlign::right,
                        .anchor = TextAnchor::middle};
  double widest = 0.0;
  for (const double value : ticks.values) {
    widest = std::max(widest, text_width(tick_label(value, ticks.decimals), style));
  }
  const std::string label = with_unit(y.label, y.unit);
  const double left = widest + 12.0 + (label.empty() ? 0.0 : 20.0);
  Frame frame;
  frame.plot = {box.x + left, box.y + 6.0, std::max(20.0, box.width - left - 14.0), height};
  frame.x = {xs.low, xs.high, frame.plot.x, frame.plot.right()};
  frame.y = {ys.low, ys.high, frame.plot.bottom(), frame.plot.y};
  std::vector<Eigen::Vector2d> ends;
  for (const double value : ticks.values) {
    const double at = frame.y(value);
    ends.emplace_back(frame.plot.x, at);
    ends.emplace_back(frame.plot.right(), at);
    canvas.text({frame.plot.x - 7.0, at}, tick_label(value, ticks.decimals), style);
  }
  canvas.lines(std::move(ends), {.colour = grid_colour});
  if (!label.empty()) {
    canvas.text({box.x + 8.0, frame.plot.y + 0.5 * height}, label,
                {.size = label_size,
                 .align = TextAlign::centre,
                 .anchor = TextAnchor::middle,
                 .angle = 90.0});
  }
  draw_x_axis(canvas, frame.plot, frame.x, x, true);
  return frame;
}

}  // namespace chart
}  // namespace kinemesh
