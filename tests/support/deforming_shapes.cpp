#include "tests/support/deforming_shapes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace kinemesh::test {

Sheet make_sheet(double width, double height, double spacing, uint64_t seed) {
  const auto columns = static_cast<uint32_t>(std::lround(width / spacing));
  const auto rows = static_cast<uint32_t>(std::lround(height / spacing));
  std::mt19937_64 random(seed);
  const auto jitter = [&](bool inner) {
    const double u = static_cast<double>(random() >> 11U) * 0x1p-53 - 0.5;
    return inner ? 0.4 * spacing * u : 0.0;
  };
  Sheet sheet;
  std::vector<Triangle> faces;
  for (uint32_t r = 0; r <= rows; ++r) {
    for (uint32_t c = 0; c <= columns; ++c) {
      const bool inner_x = c > 0 && c<columns, inner_y = r> 0 && r < rows;
      sheet.positions.emplace_back(c * width / columns + jitter(inner_x && inner_y),
                                   r * height / rows + jitter(inner_x && inner_y), 0.0);
    }
  }
  for (uint32_t r = 0; r < rows; ++r) {
    for (uint32_t c = 0; c < columns; ++c) {
      const uint32_t a = r * (columns + 1) + c, b = a + 1, d = a + columns + 1, e = d + 1;
      if ((r + c) % 2 == 0) {
        faces.push_back({a, b, e});
        faces.push_back({a, e, d});
      } else {
        faces.push_back({a, b, d});
        faces.push_back({b, e, d});
      }
    }
  }
  sheet.topology = Topology::create(sheet.positions.size(), std::move(faces));
  return sheet;
}

AnimatedMesh animate(const std::shared_ptr<const Topology>& topology,
                     const std::vector<std::vector<Eigen::Vector3d>>& frames, double rate_hz) {
  AnimatedMesh mesh(topology, frames.size(), rate_hz);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (std::size_t v = 0; v < frames[f].size(); ++v) {
      mesh.position(f, static_cast<VertexIndex>(v)) = frames[f][v].cast<float>();
    }
  }
  return mesh;
}

AnimatedMesh bumps(const Sheet& sheet, const std::vector<Bump>& all, double duration_s,
                   double rate_hz) {
  std::vector<std::vector<Eigen::Vector3d>> frames;
  const auto count = static_cast<std::size_t>(std::lround(duration_s * rate_hz));
  for (std::size_t f = 0; f < count; ++f) {
    const double t = static_cast<double>(f) / rate_hz;
    auto frame = sheet.positions;
    for (Eigen::Vector3d& p : frame) {
      for (const Bump& b : all) {
        const Eigen::Vector2d centre = b.centre + b.velocity * (t - b.time_s);
        const double r = (p.head<2>() - centre).norm() / b.sigma_mm;
        const double s = (t - b.time_s) / b.tau_s;
        p.z() += b.height_mm * std::exp(-0.5 * r * r - 0.5 * s * s);
      }
    }
    frames.push_back(std::move(frame));
  }
  return animate(sheet.topology, frames, rate_hz);
}

TwoJointCylinder two_joint_cylinder(double spacing_mm, double rate_hz) {
  constexpr double radius = 10.0, height = 120.0, bend = 50.0 * std::numbers::pi / 180.0;
  constexpr double length = 16.0;  // over which a joint bends
  const auto around = static_cast<uint32_t>(
      std::max(8L, std::lround(2.0 * std::numbers::pi * radius / spacing_mm)));
  const auto along = static_cast<uint32_t>(std::lround(height / spacing_mm));
  std::vector<Triangle> faces;
  for (uint32_t r = 0; r < along; ++r) {
    for (uint32_t c = 0; c < around; ++c) {
      const uint32_t a = r * around + c, b = r * around + (c + 1) % around;
      faces.push_back({a, a + around, b});
      faces.push_back({b, a + around, b + around});
    }
  }
  const auto topology = Topology::create(std::size_t{around} * (along + 1), std::move(faces));
  TwoJointCylinder result;
  const std::array<double, 2> tau{0.3, 0.1};
  std::vector<std::vector<Eigen::Vector3d>> frames;
  const auto count = static_cast<std::size_t>(std::lround(2.0 * rate_hz));
  for (std::size_t f = 0; f < count; ++f) {
    const double t = static_cast<double>(f) / rate_hz;
    std::vector<Eigen::Vector3d> frame;
    for (uint32_t r = 0; r <= along; ++r) {
      // The axis bends in the plane of x and y by angles that grow linearly over each joint.
      const double y = height * r / along;
      Eigen::Vector3d at = Eigen::Vector3d::Zero();
      double angle = 0.0;
      constexpr int steps = 400;
      for (int i = 0; i < steps; ++i) {
        const double here = y * (i + 0.5) / steps;
        angle = 0.0;
        for (std::size_t j = 0; j < 2; ++j) {
          const double s = (t - result.joint_time_s[j]) / tau[j];
          const double part =
              std::clamp((here - result.joint_height_mm[j]) / length + 0.5, 0.0, 1.0);
          angle += bend * std::exp(-0.5 * s * s) * part * part * (3.0 - 2.0 * part);
        }
        at += y / steps * Eigen::Vector3d(std::sin(angle), std::cos(angle), 0.0);
      }
      const Eigen::Vector3d side(std::cos(angle), -std::sin(angle), 0.0);
      for (uint32_t c = 0; c < around; ++c) {
        const double phi = 2.0 * std::numbers::pi * c / around;
        frame.push_back(at +
                        radius * (std::cos(phi) * side + std::sin(phi) * Eigen::Vector3d::UnitZ()));
      }
    }
    frames.push_back(std::move(frame));
  }
  result.mesh = animate(topology, frames, rate_hz);
  return result;
}

}  // namespace kinemesh::test
