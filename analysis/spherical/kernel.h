// The kernel of a polygon on the sphere: the points that see all of it. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh::spherical {

struct KernelPoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// Sine of the angle to the nearest edge's great circle; not above 0: the kernel is empty.
  double distance = -1.0;
  /// `distance` over the polygon's mean radius, seen from `point`.
  double roominess = 0.0;
};

/// The point of the unit sphere farthest inside the great circles of the edges ring[i] → ring[i+1],
/// the polygon on their left: the centre of the largest circle in the kernel.
KernelPoint kernel_centre(std::span<const VertexIndex> ring,
                          std::span<const Eigen::Vector3d> points);

}  // namespace kinemesh::spherical
