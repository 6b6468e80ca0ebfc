// Legends and colour bars.
#include <algorithm>
#include <cmath>

#include "report/chart.h"

namespace kinemesh {
namespace {

struct Placed {
  std::vector<Eigen::Vector2d> at;  // relative to the top left corner
  double height = 0.0;
};

Placed place(double max_width, const std::vector<LegendEntry>& entries, double size) {
  Placed placed;
  const double row = 1.55 * size;
  double x = 0.0;
  double y = 0.0;
  for (const LegendEntry& entry : entries) {
    const double wide = 1.9 * size + text_width(entry.label, {.size = size}) + 1.6 * size;
    if (x > 0.0 && x + wide > max_width) {
      x = 0.0;
      y += row;
    }
    placed.at.emplace_back(x, y);
    x += wide;
  }
  placed.height = entries.empty() ? 0.0 : y + row;
  return placed;
}

void draw_symbol(Canvas& canvas, const Eigen::Vector2d& at, const LegendEntry& entry, double size) {
  const double middle = at.y() + 0.6 * size;
  switch (entry.symbol) {
    case LegendEntry::Symbol::box:
      canvas.rectangle({at.x() + 0.2 * size, middle - 0.45 * size, 1.2 * size, 0.9 * size},
                       entry.colour);
      break;
    case LegendEntry::Symbol::dot:
      canvas.circle({at.x() + 0.9 * size, middle}, 0.42 * size, entry.colour);
      break;
    default: {
      const bool dashed = entry.symbol == LegendEntry::Symbol::dashed_line;
      canvas.line({at.x(), middle}, {at.x() + 1.6 * size, middle},
                  {.colour = entry.colour,
                   .width = 2.0,
                   .dash = dashed ? std::vector<double>{4.0, 3.0} : std::vector<double>{}});
    }
  }
}

}  // namespace

double draw_legend(Canvas& canvas, const Eigen::Vector2d& at, double max_width,
                   const std::vector<LegendEntry>& entries, double size) {
  const Placed placed = place(max_width, entries, size);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Eigen::Vector2d corner = at + placed.at[i];
    draw_symbol(canvas, corner, entries[i], size);
    canvas.text({corner.x() + 1.9 * size, corner.y() + 0.6 * size}, entries[i].label,
                {.size = size, .anchor = TextAnchor::middle});
  }
  return placed.height;
}

double legend_height(double max_width, const std::vector<LegendEntry>& entries, double size) {
  return place(max_width, entries, size).height;
}

void draw_colour_bar(Canvas& canvas, const Box& box, const ColourScale& scale) {
  const bool horizontal = box.width >= box.height;
  constexpr int steps = 128;
  constexpr double thickness = 12.0;
  const std::string title = with_unit(scale.label, scale.unit);
  const Box bar = horizontal
                      ? Box{box.x, box.y + (title.empty() ? 0.0 : 15.0), box.width, thickness}
                      : Box{box.x, box.y + (title.empty() ? 5.0 : 22.0), thickness,
                            box.height - (title.empty() ? 10.0 : 27.0)};
  for (int i = 0; i < steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const Colour colour = scale(scale.low + (t + 0.5 / steps) * (scale.high - scale.low));
    // Each step reaches under the next, so that no seam shows.
    if (horizontal) {
      canvas.rectangle({bar.x + t * bar.width, bar.y, bar.width * (1.0 - t), bar.height}, colour);
    } else {
      canvas.rectangle({bar.x, bar.y, bar.width, bar.height * (1.0 - t)}, colour);
    }
  }
  canvas.text({box.x, box.y}, title, {.size = 11.0, .anchor = TextAnchor::top});
  const double length = horizontal ? bar.width : bar.height;
  const Ticks ticks =
      nice_ticks(scale.low, scale.high, std::clamp(static_cast<int>(length / 40.0), 3, 7));
  const double span = scale.high - scale.low;
  for (const double value : ticks.values) {
    const double t = span > 0.0 ? (value - scale.low) / span : 0.5;
    TextStyle style{.size = 10.0, .colour = muted_colour};
    if (horizontal) {
      const double x = bar.x + t * bar.width;
      canvas.line({x, bar.bottom()}, {x, bar.bottom() + 3.0}, {.colour = muted_colour});
      style.align = TextAlign::centre;
      style.anchor = TextAnchor::top;
      canvas.text({x, bar.bottom() + 4.0}, tick_label(value, ticks.decimals), style);
    } else {
      const double y = bar.bottom() - t * bar.height;
      canvas.line({bar.right(), y}, {bar.right() + 3.0, y}, {.colour = muted_colour});
      style.anchor = TextAnchor::middle;
      canvas.text({bar.right() + 6.0, y}, tick_label(value, ticks.decimals), style);
    }
  }
}

}  // namespace kinemesh
