// Distance to a triangle mesh, for scoring: a uniform grid over the triangles.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mesh/closest_point.h"
#include "mesh/topology.h"

namespace kinemesh::test {

class ClosestPoint {
 public:
  /// Keeps copies. `cell_mm` should be about the triangles' size.
  ClosestPoint(std::vector<Eigen::Vector3d> positions, std::vector<Triangle> faces, double cell_mm);

  struct Hit {
    double distance = 0;  ///< mm
    FaceIndex face = invalid_index;
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< barycentric, of the closest point
  };
  Hit closest(const Eigen::Vector3d& p) const;

 private:
  using Cell = std::array<int, 3>;
  Cell cell_of(const Eigen::Vector3d& p) const;
  static uint64_t key_of(const Cell& c);
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Triangle> faces_;
  double cell_;
  Cell low_{}, high_{};
  std::unordered_map<uint64_t, std::vector<FaceIndex>> grid_;
};

using kinemesh::closest_weights;

}  // namespace kinemesh::test
