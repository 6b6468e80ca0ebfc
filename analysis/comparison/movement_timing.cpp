#include "analysis/comparison/movement_timing.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace kinemesh {
namespace {

constexpr double least_part = 0.05, most_part = 0.6;  // of the movement, where its rise is fitted
constexpr double held = 0.95;                         // of the largest: the level is held
constexpr double least_over_noise = 10.0;

double minimum_jerk(double x) { return x * x * x * (10.0 + x * (6.0 * x - 15.0)); }

/// The part of its duration at which a minimum-jerk movement has done `y` of its way.
double time_of(double y) {
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 40; ++k) {
    const double middle = (low + high) / 2.0;
    (minimum_jerk(middle) < y ? low : high) = middle;
  }
  return (low + high) / 2.0;
}

/// The movement as a part of its level, read from rest towards the level: the instant it leaves 0.
/// `at(k)` is its value at k, which is near 0 at k = 0 and above most_part at k = count − 1.
template <class Value>
double departure(Value&& at, std::size_t count) {
  std::size_t last = count - 1;
  while (last > 0 && at(last) > most_part) --last;
  std::size_t first = last;
  while (first > 0 && at(first) > least_part) --first;
  if (at(first) <= least_part) ++first;
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t k = first; k <= last; ++k) {
    const double x = static_cast<double>(k), y = time_of(at(k));
    n += 1.0;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const double spread = n * sxx - sx * sx, slope = n * sxy - sx * sy;
  if (n < 3.0 || !(spread > 0.0) || !(slope > 0.0)) return static_cast<double>(first);
  return std::clamp((sx - sy * spread / slope) / n, 0.0, static_cast<double>(last));
}

std::vector<double> smoothed(std::span<const double> curve, double sigma) {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> result(curve.size());
  for (std::size_t f = 0; f < curve.size(); ++f) {
    double sum = 0.0, weight = 0.0;
    for (int d = -reach; d <= reach; ++d) {
      const auto at = static_cast<std::ptrdiff_t>(f) + d;
      if (at < 0 || at >= static_cast<std::ptrdiff_t>(curve.size())) continue;
      const double w = sigma > 0.0 ? std::exp(-0.5 * d * d / (sigma * sigma)) : 1.0;
      sum += w * curve[static_cast<std::size_t>(at)];
      weight += w;
    }
    result[f] = sum / weight;
  }
  return result;
}

struct Span {
  std::size_t first = 0, last = 0;
};

/// The frames around `top` whose value is above `part` of the level.
Span above(const std::vector<double>& c, std::size_t top, double part) {
  Span s{top, top};
  while (s.first > 0 && c[s.first - 1] > part) --s.first;
  while (s.last + 1 < c.size() && c[s.last + 1] > part) ++s.last;
  return s;
}

double median_over(const std::vector<double>& c, const Span& s) {
  std::vector<double> values(c.begin() + static_cast<std::ptrdiff_t>(s.first),
                             c.begin() + static_cast<std::ptrdiff_t>(s.last) + 1);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// `c` is 0 at rest and 1 around `at`; `end` is the last frame of that level.
MovementTiming follow(const std::vector<double>& c, std::size_t at, std::size_t end,
                      double rate_hz) {
  const Span most = above(c, at, most_part);
  const std::size_t last = c.size() - 1;
  MovementTiming timing;
  timing.onset_s = departure([&](std::size_t k) { return c[k]; }, most.first + 1) / rate_hz;
  // What is missing, followed back from the level to the rise.
  std::size_t start = at;
  while (start > 0 && c[start] > 1.0 - most_part) --start;
  const auto missing = [&](std::size_t k) { return 1.0 - c[end - k]; };
  timing.peak_s = (static_cast<double>(end) - departure(missing, end - start + 1)) / rate_hz;
  timing.comes_back = c[last] < 0.5 && most.last < last;
  timing.offset_s = static_cast<double>(last) / rate_hz;
  if (timing.comes_back) {
    const auto back = [&](std::size_t k) { return c[last - k]; };
    timing.offset_s -= departure(back, last - most.last + 1) / rate_hz;
  }
  return timing;
}

}  // namespace

std::optional<MovementTiming> movement_timing(std::span<const double> curve, double rate_hz,
                                              double rest, double noise) {
  if (curve.size() < 8 || !(rate_hz > 0.0)) return {};
  std::vector<double> c(curve.begin(), curve.end());
  for (double& value : c) value -= rest;
  const auto strongest = static_cast<std::size_t>(
      std::ranges::max_element(c, {}, [](double v) { return std::abs(v); }) - c.begin());
  if (!(std::abs(c[strongest]) > least_over_noise * noise) || c[strongest] == 0.0) return {};
  const double sign = c[strongest] > 0.0 ? 1.0 : -1.0;
  const double largest = std::abs(c[strongest]);
  for (double& value : c) value *= sign / largest;
  // The level is what is held, not the highest sample of its noise.
  const double level = median_over(c, above(c, strongest, held));
  for (double& value : c) value /= level;
  MovementTiming timing = follow(c, strongest, above(c, strongest, held).last, rate_hz);
  timing.level = rest + sign * largest * level;
  return timing;
}

std::optional<MovementTiming> timing_around(std::span<const double> curve, double rate_hz,
                                            std::size_t at) {
  if (curve.size() < 8 || at >= curve.size() || !(rate_hz > 0.0)) return {};
  const std::vector<double> c(curve.begin(), curve.end());
  if (!(c[at] > most_part) || above(c, at, most_part).first == 0) return {};
  MovementTiming timing = follow(c, at, at, rate_hz);
  timing.level = 1.0;
  return timing;
}

double peak_speed(std::span<const double> curve, double rate_hz, double smoothing_s) {
  if (curve.size() < 2 || !(rate_hz > 0.0)) return 0.0;
  const std::vector<double> c = smoothed(curve, smoothing_s * rate_hz);
  double fastest = 0.0;
  for (std::size_t f = 1; f < c.size(); ++f)
    fastest = std::max(fastest, std::abs(c[f] - c[f - 1]) * rate_hz);
  return fastest;
}

}  // namespace kinemesh
