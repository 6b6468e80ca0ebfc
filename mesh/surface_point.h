// Points on a surface, and maps that give a point of one mesh for every vertex of another.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

/// A point of a triangle mesh: the face and its barycentric weights (sum 1) at corners 0, 1, 2.
struct SurfacePoint {
  FaceIndex face = invalid_index;  ///< invalid_index: no point (unmapped)
  std::array<double, 3> weights{0.0, 0.0, 0.0};
  bool valid() const { return face != invalid_index; }
};

/// The position of a surface point, in the units of `positions` (one 3-vector per vertex).
template <class Positions>
Eigen::Vector3d position_of(const SurfacePoint& point, const Topology& topology,
                            const Positions& positions) {
  const Triangle& face = topology.faces()[point.face];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    sum += point.weights[corner] * positions[face[corner]].template cast<double>();
  }
  return sum;
}

/// A map from a source mesh to a target mesh: `points[v]` is the image on the target of source
/// vertex v. The direction is source → target and is written with every file and picture.
struct SurfaceMap {
  std::string source_name;
  std::string target_name;
  std::vector<SurfacePoint> points;  ///< one per source vertex; invalid where unmapped
  std::vector<double> confidence;    ///< empty, or one per source vertex in [0, 1]
};

}  // namespace kinemesh
