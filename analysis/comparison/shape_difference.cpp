#include "analysis/comparison/shape_difference.h"

#include <limits>

#include "capture/rigid_fit.h"
#include "mesh/closest_point.h"
#include "mesh/surface_measures.h"

namespace kinemesh::comparison {

ShapeFit fit_shape(const Comparison& c, const Topology& topology_b, bool with_scale) {
  std::vector<Eigen::Vector3d> from, to;
  std::vector<double> weights;
  for (std::size_t v = 0; v < c.forward.points.size(); ++v) {
    if (!c.forward.points[v].valid()) continue;
    from.push_back(position_of(c.forward.points[v], topology_b, c.b.rest));
    to.push_back(c.a.rest[v]);
    weights.push_back(c.a.areas[v] * (1e-3 + c.forward.confidence[v]));
  }
  const RigidFit rigid = fit_rigid(from, to, weights);
  ShapeFit fit{rigid.rotation, 1.0, rigid.translation};
  if (!with_scale) return fit;
  Eigen::Vector3d mean_from = Eigen::Vector3d::Zero(), mean_to = mean_from;
  double total = 0.0, along = 0.0, spread = 0.0;
  for (std::size_t k = 0; k < from.size(); ++k) {
    mean_from += weights[k] * from[k];
    mean_to += weights[k] * to[k];
    total += weights[k];
  }
  if (!(total > 0.0)) return fit;
  mean_from /= total;
  mean_to /= total;
  for (std::size_t k = 0; k < from.size(); ++k) {
    const Eigen::Vector3d turned = fit.turn * (from[k] - mean_from);
    along += weights[k] * turned.dot(to[k] - mean_to);
    spread += weights[k] * turned.squaredNorm();
  }
  if (spread > 0.0 && along > 0.0) fit.scale = along / spread;
  fit.shift = mean_to - fit.scale * (fit.turn * mean_from);
  return fit;
}

std::vector<float> signed_distances(const Comparison& c, const Topology& topology_a,
                                    const Topology& topology_b, const ShapeFit& fit) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3d& p : c.b.rest) positions.push_back(fit(p));
  const ClosestPointSearch search(positions, topology_b.faces());
  const std::vector<Eigen::Vector3d> normals = vertex_normals(topology_a, c.a.rest);
  std::vector<float> distances(c.a.rest.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t v = 0; v < distances.size(); ++v) {
    if (!c.forward.points[v].valid()) continue;
    // The near lip, not the one behind it; without any that faces alike, whatever is nearest.
    ClosestHit hit = search.closest(c.a.rest[v], std::numeric_limits<double>::infinity(),
                                    normals[v].squaredNorm() > 0.0 ? &normals[v] : nullptr);
    if (!hit.point.valid()) hit = search.closest(c.a.rest[v]);
    if (!hit.point.valid()) continue;
    const double side = normals[v].dot(hit.position - c.a.rest[v]);
    distances[v] = static_cast<float>(side < 0.0 ? -hit.distance : hit.distance);
  }
  return distances;
}

}  // namespace kinemesh::comparison
