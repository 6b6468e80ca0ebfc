#include "tests/support/bending_cylinder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinemesh::test {
namespace {

Eigen::Vector3d straight(const CylinderShape& s, double angle, double along) {
  const double swell =
      1.0 + s.bulge * std::exp(-std::pow((along - 0.2) / 0.15, 2)) * std::max(0.0, std::cos(angle));
  // Tapered to closed ends.
  const double end = std::min(along, 1.0 - along) * s.length_mm / s.radius_mm;
  const double round = end >= 1.0 ? 1.0 : std::sqrt(std::max(0.0, 1.0 - (1.0 - end) * (1.0 - end)));
  const double radius = s.radius_mm * swell * round;
  return {along * s.length_mm, radius * std::cos(angle), radius * std::sin(angle)};
}

/// Rises and falls once: sin² between two moments.
double pulse(double time, double from, double to) {
  if (time <= from || time >= to) return 0.0;
  return std::pow(std::sin(std::numbers::pi * (time - from) / (to - from)), 2);
}

/// Turns about z what lies beyond the joint, smoothly over a diameter.
Eigen::Vector3d bent(const CylinderShape& s, Eigen::Vector3d p, double time) {
  const auto bend = [&](double joint, double angle) {
    const double x0 = joint * s.length_mm, width = 2.0 * s.radius_mm;
    const double part = std::clamp((p.x() - x0) / width + 0.5, 0.0, 1.0);
    const double a = angle * part * part * (3.0 - 2.0 * part);
    const Eigen::Vector3d q = p - Eigen::Vector3d(x0, 0.0, 0.0);
    p = Eigen::Vector3d(x0 + std::cos(a) * q.x() - std::sin(a) * q.y(),
                        std::sin(a) * q.x() + std::cos(a) * q.y(), q.z());
  };
  bend(s.second_joint, s.second_angle * pulse(time, 0.1, 0.9));
  bend(s.first_joint, s.first_angle * pulse(time, 0.35, 0.6));
  return p;
}

std::shared_ptr<const Topology> grid(const CylinderShape& s) {
  std::vector<Triangle> faces;
  const auto vertex = [&](int ring, int k) {
    return static_cast<VertexIndex>(ring * s.around + k % s.around);
  };
  const int rings = s.along - 1;
  for (int ring = 0; ring + 1 < rings; ++ring) {
    for (int k = 0; k < s.around; ++k) {
      faces.push_back({vertex(ring, k), vertex(ring + 1, k), vertex(ring, k + 1)});
      faces.push_back({vertex(ring, k + 1), vertex(ring + 1, k), vertex(ring + 1, k + 1)});
    }
  }
  const auto low = static_cast<VertexIndex>(rings * s.around), high = low + 1;
  for (int k = 0; k < s.around; ++k) {
    faces.push_back({low, vertex(0, k), vertex(0, k + 1)});
    faces.push_back({high, vertex(rings - 1, k + 1), vertex(rings - 1, k)});
  }
  return std::make_shared<const Topology>(high + std::size_t{1}, std::move(faces));
}

}  // namespace

Eigen::Vector3d BendingCylinder::rest_place(const std::pair<double, double>& parameter) const {
  return straight(shape, parameter.first, parameter.second);
}

BendingCylinder make_bending_cylinder(const CylinderShape& s) {
  BendingCylinder result{.shape = s};
  for (int ring = 1; ring < s.along; ++ring) {
    for (int k = 0; k < s.around; ++k) {
      result.parameters.emplace_back(2.0 * std::numbers::pi * k / s.around,
                                     static_cast<double>(ring) / s.along);
    }
  }
  result.parameters.emplace_back(0.0, 0.0);
  result.parameters.emplace_back(0.0, 1.0);
  result.mesh = AnimatedMesh(grid(s), static_cast<std::size_t>(s.frames), s.rate_hz);
  for (std::size_t f = 0; f < result.mesh.frame_count(); ++f) {
    const double time = static_cast<double>(f) / (s.frames - 1);
    for (std::size_t v = 0; v < result.parameters.size(); ++v) {
      result.mesh.position(f, static_cast<VertexIndex>(v)) =
          bent(s, result.rest_place(result.parameters[v]), time).cast<float>();
    }
  }
  return result;
}

std::vector<std::pair<CylinderShape, CylinderShape>> bending_cylinder_pairs() {
  const CylinderShape plain;
  CylinderShape dense = plain, quick = plain, thick = plain, longer = plain;
  dense.around = 34;
  dense.along = 114;
  quick.frames = 120;
  quick.rate_hz = 60;
  thick.radius_mm = 24;
  longer.length_mm = 230;
  longer.first_angle = 0.7;
  return {{plain, dense}, {plain, quick}, {plain, thick}, {dense, longer}};
}

}  // namespace kinemesh::test
