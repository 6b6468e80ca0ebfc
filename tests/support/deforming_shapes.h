// Animations whose deformation is known in closed form.
#pragma once

#include "mesh/animated_mesh.h"

namespace kinemesh::test {

/// A sheet of width × height mm in the plane z = 0 with a vertex about every `spacing` mm, slightly
/// irregular; the boundary is straight.
struct Sheet {
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> positions;
};
Sheet make_sheet(double width, double height, double spacing, uint64_t seed);

/// One frame of positions as the next frame of an animation.
AnimatedMesh animate(const std::shared_ptr<const Topology>& topology,
                     const std::vector<std::vector<Eigen::Vector3d>>& frames, double rate_hz);

/// A bump that rises out of a sheet and sinks again: height · exp(−r²/2σ²) · exp(−(t − t₀)²/2τ²).
struct Bump {
  Eigen::Vector2d centre;
  double sigma_mm, time_s, tau_s, height_mm;
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< mm/s, about its time
};
AnimatedMesh bumps(const Sheet& sheet, const std::vector<Bump>& all, double duration_s,
                   double rate_hz);

/// A cylinder of radius 10 mm and height 120 mm along y whose axis bends at heights 40 and 80 mm by
/// 50 degrees each (figure 4-15): the lower joint slowly (its speed is largest at 1 s, a standard
/// deviation of 0.25 s), the upper one quickly (at 1.4 s, 0.08 s), then back again.
struct TwoJointCylinder {
  AnimatedMesh mesh;
  std::array<double, 2> joint_height_mm{40, 80};
  std::array<double, 2> joint_time_s{0.8, 1.5};  ///< of the largest bend
};
TwoJointCylinder two_joint_cylinder(double spacing_mm, double rate_hz);

}  // namespace kinemesh::test
