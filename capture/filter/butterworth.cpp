#include "capture/filter/butterworth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinemesh::filter {
namespace {

/// Transposed direct form II, starting in the steady state of the first value.
void run(std::span<const Section> sections, std::vector<double>& values) {
  double level = values.front();  // the steady input of each section; gains at 0 are 1
  for (const Section& s : sections) {
    double z2 = (s.b2 - s.a2) * level;
    double z1 = (s.b1 - s.a1) * level + z2;
    for (double& x : values) {
      const double y = s.b0 * x + z1;
      z1 = s.b1 * x - s.a1 * y + z2;
      z2 = s.b2 * x - s.a2 * y;
      x = y;
    }
  }
}

}  // namespace

std::vector<Section> butterworth_sections(int order, double cutoff_hz, double rate_hz) {
  const double warped = std::tan(std::numbers::pi * cutoff_hz / rate_hz);
  std::vector<Section> sections;
  for (int k = 0; k < order / 2; ++k) {
    // Poles of the prototype at exp(±i (π/2 + θ)): s² + 2 sin θ' s + 1 with the damping below.
    const double damping = 2.0 * std::sin(std::numbers::pi * (2.0 * k + 1.0) / (2.0 * order));
    const double norm = 1.0 / (1.0 + damping * warped + warped * warped);
    const double b = warped * warped * norm;
    sections.push_back({b, 2.0 * b, b, 2.0 * (warped * warped - 1.0) * norm,
                        (1.0 - damping * warped + warped * warped) * norm});
  }
  if (order % 2 != 0) {
    const double norm = 1.0 / (1.0 + warped);
    sections.push_back({warped * norm, warped * norm, 0.0, (warped - 1.0) * norm, 0.0});
  }
  return sections;
}

void filter_both_ways(std::span<const Section> sections, int order, std::span<double> values) {
  const std::size_t n = values.size();
  if (n < 2) return;
  const std::size_t pad = std::min(n - 1, static_cast<std::size_t>(3 * (order + 1)));
  std::vector<double> wide;
  wide.reserve(n + 2 * pad);
  for (std::size_t i = pad; i > 0; --i) wide.push_back(2.0 * values.front() - values[i]);
  wide.insert(wide.end(), values.begin(), values.end());
  for (std::size_t i = 1; i <= pad; ++i) wide.push_back(2.0 * values.back() - values[n - 1 - i]);
  run(sections, wide);
  std::ranges::reverse(wide);
  run(sections, wide);
  std::ranges::reverse(wide);
  std::copy_n(wide.begin() + static_cast<std::ptrdiff_t>(pad), n, values.begin());
}

}  // namespace kinemesh::filter
