// The frame that all charts share. Private to report/.
#pragma once

#include <string>

#include "report/canvas.h"
#include "report/chart.h"

namespace kinemesh::chart {

inline constexpr double label_size = 11.0;
inline constexpr double title_size = 14.0;

/// A range of values over a range of pixels.
struct Scale {
  double low = 0.0, high = 1.0;
  double from = 0.0, to = 1.0;  ///< pixels of low and high
  double operator()(double value) const {
    return from + (to - from) * (high > low ? (value - low) / (high - low) : 0.5);
  }
};

struct Range {
  double low, high;
};
/// The axis' own limits, otherwise those of the data; never empty, with `margin` (a fraction of
/// the range) at the ends that come from the data.
Range range_of(const Axis& axis, double data_low, double data_high, double margin);

/// Title at the top; returns what is left of the box.
Box draw_title(Canvas& canvas, const Box& box, const std::string& title);

/// A plot area with grid lines, numbers and labels.
struct Frame {
  Box plot;
  Scale x, y;
};
Frame draw_axes(Canvas& canvas, const Box& box, const Axis& x, const Range& xs, const Axis& y,
                const Range& ys);
/// Numbers and label of the x axis below the plot.
void draw_x_axis(Canvas& canvas, const Box& plot, const Scale& scale, const Axis& axis, bool grid);
/// Height that draw_x_axis takes below the plot.
double x_axis_height(const Axis& axis);

}  // namespace kinemesh::chart
