// The point of a triangle mesh that is closest to a point in space: a bounding volume hierarchy,
// quick near and far.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

/// Barycentric weights of the point of triangle abc that is closest to p (Ericson 2005, 5.1.5).
Eigen::Vector3d closest_weights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b, const Eigen::Vector3d& c);

struct ClosestHit {
  SurfacePoint point;  ///< invalid when nothing lies within the distance asked for
  double distance = std::numeric_limits<double>::infinity();  ///< mm
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// Immutable; safe to use from several threads.
class ClosestPointSearch {
 public:
  /// Keeps copies. Faces with a corner that is not finite are left out.
  ClosestPointSearch(std::span<const Eigen::Vector3d> positions, std::vector<Triangle> faces);

  /// The closest point within `within` mm. With a `normal` (unit), only faces count whose own
  /// normal is less than 90° from it: the near lip, not the one behind it.
  ClosestHit closest(const Eigen::Vector3d& p,
                     double within = std::numeric_limits<double>::infinity(),
                     const Eigen::Vector3d* normal = nullptr) const;

 private:
  struct Node {
    Eigen::Vector3d low, high;
    uint32_t first = 0, count = 0;  ///< leaf: entries of order_; else count = 0
    uint32_t right = 0;             ///< index of the right child; the left one follows the node
    double squared_distance(const Eigen::Vector3d& p) const {
      return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
    }
  };
  uint32_t build(uint32_t first, uint32_t count, const std::vector<Eigen::Vector3d>& centres);

  std::vector<Eigen::Vector3d> positions_;
  std::vector<Triangle> faces_;
  std::vector<FaceIndex> order_;
  std::vector<Node> nodes_;
};

}  // namespace kinemesh
