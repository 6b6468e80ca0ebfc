#include "mesh/formats/float_times.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinemesh {

double rate_from_float_times(double first, double last, std::size_t steps) {
  const double span = last - first;
  if (!(span > 0) || !std::isfinite(span) || steps == 0) return 0.0;
  const double rate = static_cast<double>(steps) / span;
  const double rounding =
      std::max(std::abs(first), std::abs(last)) * double{std::numeric_limits<float>::epsilon()};
  const double near_whole = std::clamp(rounding / span, 1e-4, 1e-3);
  if (std::abs(rate - std::round(rate)) < near_whole * rate) return std::round(rate);
  const double decimals = std::round(rate * 1000) / 1000;
  return std::abs(rate - decimals) < 2e-6 * rate ? decimals : rate;
}

}  // namespace kinemesh
