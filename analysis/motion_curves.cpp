#include "analysis/motion_curves.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "mesh/surface_measures.h"

namespace kinemesh {
namespace {

constexpr std::array quantiles{0.50, 0.75, 0.90, 0.95, 0.99};

}  // namespace

MotionCurves motion_signature(const AnimatedMesh& animation, const DeformationResult& deformation) {
  const std::vector<double> areas = vertex_areas(animation.topology(), deformation.rest);
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  MotionCurves curves(animation.frame_count(), quantiles.size(), animation.rate_hz);
  std::vector<VertexIndex> order(areas.size());
  std::iota(order.begin(), order.end(), VertexIndex{0});
  for (std::size_t f = 0; f < curves.frame_count; ++f) {
    const auto value = [&](VertexIndex v) { return deformation.values.of(v)[f]; };
    std::ranges::sort(order, {}, value);
    double below = 0.0;
    std::size_t q = 0;
    for (const VertexIndex v : order) {
      below += areas[v];
      while (q < quantiles.size() && below >= quantiles[q] * total) {
        curves.at(f, q++) = static_cast<double>(value(v));
      }
    }
  }
  return curves;
}

MotionCurves curves_of(const VertexCurves& curves, std::span<const VertexIndex> vertices,
                       double rate_hz) {
  MotionCurves result(curves.frame_count, vertices.size(), rate_hz);
  for (std::size_t c = 0; c < vertices.size(); ++c) {
    const std::span<const float> curve = curves.of(vertices[c]);
    for (std::size_t f = 0; f < curve.size(); ++f) result.at(f, c) = static_cast<double>(curve[f]);
  }
  return result;
}

}  // namespace kinemesh
