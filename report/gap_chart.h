// When which marker was missing, and what was done about it: a row per marker over time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "report/canvas.h"
#include "report/colour.h"

namespace kinemesh {

/// What happened to samples; intervals refer to it by index.
struct GapStyle {
  std::string label;  ///< for the legend: "filled by spline"
  Colour colour;
  bool measured = false;  ///< drawn, but not counted as missing
};
/// 0 missing, 1 filled by spline, 2 estimated from other markers, 3 repaired.
std::vector<GapStyle> default_gap_styles();

struct GapInterval {
  std::size_t begin = 0;  ///< first frame, 0-based
  std::size_t end = 0;    ///< one past the last
  std::size_t kind = 0;   ///< index into GapChart::kinds; any other counts as the first
};

struct GapChart {
  struct Row {
    std::string label;
    std::vector<GapInterval> gaps;
  };
  enum class Order { as_given, worst_first };

  std::string title = "Gaps over time";
  std::string subtitle;  ///< the take; may be empty
  std::vector<Row> markers;
  std::vector<GapStyle> kinds = default_gap_styles();
  std::size_t frame_count = 0;
  double rate_hz = 0.0;     ///< 0 when unknown: the axis then counts frames only
  int64_t first_frame = 1;  ///< number of frame 0 as the user knows it
  Order order = Order::worst_first;
};

/// The chart on a canvas of `width` pixels, as high as its rows need. Intervals outside the take
/// are cut off, gaps narrower than a pixel widened to one.
Canvas draw_gap_chart(const GapChart& chart, double width = 1200.0);
/// Pixels per canvas unit that keep a PNG of it below about 8 megapixels.
double png_scale(const Canvas& canvas);

}  // namespace kinemesh
