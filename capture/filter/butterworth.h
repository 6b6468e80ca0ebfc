// Digital Butterworth low-pass filters, run forwards and backwards. Internal to filtering.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace kinemesh::filter {

/// A section of second order: (b0 + b1 z⁻¹ + b2 z⁻²) / (1 + a1 z⁻¹ + a2 z⁻²).
struct Section {
  double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0;
};

/// Bilinear transform of the analogue prototype, its cut-off (−3 dB) prewarped; unit gain at 0.
/// 0 < cutoff < rate / 2; order ≥ 1.
std::vector<Section> butterworth_sections(int order, double cutoff_hz, double rate_hz);

/// Forwards and backwards without delay. Each end is continued by its point reflection (odd
/// padding) over as many samples as SciPy's sosfiltfilt takes, or as there are; each pass starts
/// in the steady state of its first value.
void filter_both_ways(std::span<const Section> sections, int order, std::span<double> values);

}  // namespace kinemesh::filter
