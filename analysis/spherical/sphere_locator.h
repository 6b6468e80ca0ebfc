// Which triangle of a mesh on the unit sphere a point lies in.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

class SphereLocator {
 public:
  /// Keeps references. The mesh must cover the sphere once (check_sphere).
  SphereLocator(const Topology& topology, std::span<const Eigen::Vector3d> points);

  /// The face whose cone from the origin holds p, and the weights of where the ray through p meets
  /// it: a walk from face `hint` towards p, or from a face near p without one.
  SurfacePoint locate(const Eigen::Vector3d& p, FaceIndex hint = invalid_index) const;

 private:
  bool walk(const Eigen::Vector3d& p, FaceIndex& face) const;
  FaceIndex search_all(const Eigen::Vector3d& p) const;
  std::size_t cell_of(const Eigen::Vector3d& p) const;
  double side(HalfedgeIndex h, const Eigen::Vector3d& p) const;
  SurfacePoint weigh(FaceIndex face, const Eigen::Vector3d& p) const;

  const Topology& topology_;
  std::span<const Eigen::Vector3d> points_;
  std::size_t resolution_ = 1;
  std::vector<FaceIndex> cells_;  // of a cube's six sides: a face near each cell's middle
};

}  // namespace kinemesh
