#include "analysis/animation_similarity.h"

#include <algorithm>
#include <cmath>

namespace kinemesh {
namespace {

/// Mean of |ln(speed of the warp)| where something moves: 0 when only delayed.
double bending_of(const TimeWarpResult& warp) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t f = 1; f < warp.b_of_a_s.size(); ++f) {
    if (warp.determined[f] == 0 || warp.determined[f - 1] == 0) continue;
    const double speed = (warp.b_of_a_s[f] - warp.b_of_a_s[f - 1]) * warp.rate_hz;
    sum += std::abs(std::log(std::clamp(speed, 0.1, 10.0)));
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace

AnimationSimilarity similarity_of(const FeatureAlignment& features, const TimeWarpResult& warp) {
  AnimationSimilarity result;
  result.features = features.similarity;
  result.curves = 1.0 - std::min(1.0, warp.difference);
  result.timing = std::exp(-bending_of(warp));
  result.overall = (result.features + result.curves + result.timing) / 3.0;
  return result;
}

}  // namespace kinemesh
