// Charts: lines, bars, histograms, heat strips, with axes, legends and colour bars. Each is a
// plain struct that draws itself into a box of a canvas.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "report/canvas.h"
#include "report/colour.h"

namespace kinemesh {

/// Round numbers 1, 2 or 5 times a power of ten apart.
struct Ticks {
  std::vector<double> values;  ///< ascending, all within the range asked for
  double step = 1.0;
  int decimals = 0;  ///< that tell the values apart
};
/// At most `at_most` (≥ 2) ticks in [low, high], as many as the steps allow. A range that is
/// empty or not finite gives the one tick `low`, or none. `integer` keeps the step ≥ 1.
Ticks nice_ticks(double low, double high, int at_most, bool integer = false);
/// With a true minus sign and, from 10,000 on, commas.
std::string tick_label(double value, int decimals);
/// "strain (%)"
std::string with_unit(const std::string& label, const std::string& unit);

struct Axis {
  std::string label{};
  std::string unit{};
  std::optional<double> low{};   ///< otherwise from the data
  std::optional<double> high{};  ///< otherwise from the data
  bool from_zero = false;        ///< 0 belongs to the range
  bool integer = false;          ///< no ticks between whole numbers
};

/// A curve; NaN in y interrupts it. x ascending; thinned to what the width can show, extremes kept.
struct Series {
  std::string label;
  std::vector<double> x, y;
  Colour colour = series_colour(0);
  double width = 1.6;
  bool dashed = false;
  bool dots = false;  ///< points instead of a line
};

struct LineChart {
  /// A stretch of x to be noticed, behind the curves.
  struct Band {
    double from, to;
    Colour colour;
    std::string label{};  ///< for the legend; empty for none
  };
  /// An instant or a level, with its name beside the line.
  struct Mark {
    double at;
    std::string label;
  };
  std::string title;
  Axis x, y;
  std::vector<Series> series;
  std::vector<Band> bands;
  std::vector<Mark> instants;  ///< vertical dashed lines
  std::vector<Mark> levels;    ///< horizontal dashed lines
  void draw(Canvas& canvas, const Box& box) const;
};

/// Horizontal bars, one per label, with the value written at the end.
struct BarChart {
  struct Bar {
    std::string label;
    double value;
    Colour colour = series_colour(0);
  };
  std::string title;
  Axis value;
  int decimals = 1;  ///< of the values written
  std::vector<Bar> bars;
  /// Height that shows every bar legibly.
  double natural_height() const;
  void draw(Canvas& canvas, const Box& box) const;
};

/// Counts of values in bins of equal, round width.
struct Histogram {
  std::string title;
  Axis x;
  std::vector<double> values;  ///< NaN is left out
  int bins = 30;               ///< about as many
  Colour colour = series_colour(0);
  void draw(Canvas& canvas, const Box& box) const;
};

/// One row of colours per quantity over a common axis, with a colour bar.
struct HeatStrip {
  struct Row {
    std::string label;
    std::vector<double> values;  ///< equidistant over the x axis
  };
  std::string title;
  Axis x;  ///< low and high are the edges of the first and last value
  std::vector<Row> rows;
  ColourScale scale;
  void draw(Canvas& canvas, const Box& box) const;
};

struct LegendEntry {
  enum class Symbol { line, dashed_line, box, dot };
  std::string label;
  Colour colour;
  Symbol symbol = Symbol::box;
};
/// Entries side by side from the top left corner, in rows of at most `max_width`; returns the
/// height taken.
double draw_legend(Canvas& canvas, const Eigen::Vector2d& at, double max_width,
                   const std::vector<LegendEntry>& entries, double size = 11.0);
/// The height that draw_legend would take.
double legend_height(double max_width, const std::vector<LegendEntry>& entries, double size = 11.0);

/// A colour bar with its numbers and label: horizontal when the box is wider than high (needs 40
/// px of height), otherwise vertical (needs 70 px of width).
void draw_colour_bar(Canvas& canvas, const Box& box, const ColourScale& scale);

/// A chart on a canvas of its own.
template <class Chart>
Canvas canvas_of(const Chart& chart, double width, double height) {
  Canvas canvas(width, height);
  chart.draw(canvas, {0.0, 0.0, width, height});
  return canvas;
}

}  // namespace kinemesh
