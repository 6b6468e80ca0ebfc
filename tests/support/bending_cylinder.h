// A cylinder along x that bends at two joints, one quicker than the other, on any density: every
// vertex knows its place by (angle, length), so that truth holds between densities and proportions.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "mesh/animated_mesh.h"

namespace kinemesh::test {

struct CylinderShape {
  double length_mm = 200, radius_mm = 20;
  int around = 24, along = 80;
  int frames = 60;
  double rate_hz = 30;
  double first_joint = 0.3, second_joint = 0.68;  ///< parts of the length
  double first_angle = 0.9, second_angle = 0.9;   ///< radians when fully bent
  /// A bulge on one side, so that a turn about the axis is no symmetry of the shape.
  double bulge = 0.25;
};

struct BendingCylinder {
  CylinderShape shape;
  AnimatedMesh mesh{};
  std::vector<std::pair<double, double>> parameters{};  ///< angle, part of the length; per vertex
  /// The rest pose at a parameter.
  Eigen::Vector3d rest_place(const std::pair<double, double>& parameter) const;
};

BendingCylinder make_bending_cylinder(const CylinderShape& shape = {});
/// Pairs that differ in density, frame rate and proportions.
std::vector<std::pair<CylinderShape, CylinderShape>> bending_cylinder_pairs();

}  // namespace kinemesh::test
