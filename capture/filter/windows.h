// Filters over a sliding window. Internal to filtering.
#pragma once

#include <span>

namespace kinemesh::filter {

/// Least-squares polynomials over `window` (odd) samples; at both ends the polynomial of the first
/// or last window is used. Nothing happens when there are fewer samples than the window.
void savitzky_golay(std::span<double> values, int window, int degree);
/// The end values are repeated beyond the ends.
void moving_average(std::span<double> values, int window);
void moving_median(std::span<double> values, int window);

}  // namespace kinemesh::filter
