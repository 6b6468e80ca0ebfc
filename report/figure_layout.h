// Sizes that figures share, in points of a Canvas.
#pragma once

namespace kinemesh {

inline constexpr double figure_margin = 18.0;
/// From the top of a figure to its panels: title and subtitle.
inline constexpr double figure_heading = 66.0;
/// Height of the colour bar below the panels.
inline constexpr double figure_bar_height = 52.0;

}  // namespace kinemesh
