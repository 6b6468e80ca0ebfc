// Marker clouds on analytic surfaces for the tests of the triangulation.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <random>
#include <string>

#include "capture/marker_sequence.h"
#include "reconstruct/edit_mesh.h"

namespace kinemesh::test {

/// A take of one or more frames, all measured, markers named m0, m1, …
inline MarkerSequence make_take(const std::vector<Points>& frames, double rate_hz = 100.0) {
  std::vector<Marker> markers(frames.at(0).size());
  for (std::size_t m = 0; m < markers.size(); ++m) markers[m].label = "m" + std::to_string(m);
  MarkerSequence take = MarkerSequence::invalid(frames.size(), markers, rate_hz);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (std::size_t m = 0; m < markers.size(); ++m) {
      take.position(f, m) = frames[f][m].cast<float>();
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
    }
  }
  return take;
}

/// Points of `surface` over [0, 1]² at least `spacing` apart, by dart throwing.
inline Points scatter(const std::function<Eigen::Vector3d(double, double)>& surface, double spacing,
                      unsigned seed, int darts = 20000) {
  std::mt19937 random(seed);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  Points points;
  for (int i = 0; i < darts; ++i) {
    const double u = uniform();
    const Eigen::Vector3d p = surface(u, uniform());
    bool free = true;
    for (const auto& q : points) free = free && (p - q).norm() >= spacing;
    if (free) points.push_back(p);
  }
  return points;
}

/// A cap of the sphere of `radius` about 0 up to `angle` (radians) from +z, uniform in area.
inline std::function<Eigen::Vector3d(double, double)> cap(double radius, double angle) {
  return [=](double u, double v) {
    const double z = 1 - u * (1 - std::cos(angle));
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    const double phi = 2 * std::acos(-1.0) * v;
    return Eigen::Vector3d(radius * r * std::cos(phi), radius * r * std::sin(phi), radius * z);
  };
}

}  // namespace kinemesh::test
