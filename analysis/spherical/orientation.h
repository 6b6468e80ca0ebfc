// Exact orientation of triangles on the unit sphere, and the strict test of a spherical map.
#pragma once

#include <Eigen/Core>
#include <span>

#include "mesh/topology.h"

namespace kinemesh {

/// Sign of det(a, b, c): 1 when a, b, c run counter-clockwise seen from outside the sphere, −1
/// clockwise, 0 on one great circle. Exact for coordinates that are 0 or at least 1e-80 in size
/// (floating-point filter, then expansions: Shewchuk 1997).
int orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Signed solid angle of the triangle a, b, c of unit vectors (Van Oosterom & Strackee 1983).
double solid_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// A closed mesh covers the sphere once, without folds, exactly when every triangle is
/// counter-clockwise and the solid angles sum to 4π. (Determinants alone pass a mesh that winds
/// twice around the sphere.)
struct SphereCheck {
  std::size_t folded = 0;  ///< triangles that are not strictly counter-clockwise
  FaceIndex first_folded = invalid_index;
  double solid_angle = 0.0;           ///< sum over all triangles
  double smallest_determinant = 0.0;  ///< det(a, b, c) over all triangles
  bool valid() const;
};
SphereCheck check_sphere(const Topology& topology, std::span<const Eigen::Vector3d> points);

}  // namespace kinemesh
