#include "mesh/mirror_plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace kinemesh {
namespace {

using Vectors = std::vector<Eigen::Vector3d>;

class MirrorSearch {
 public:
  MirrorSearch(const Vectors& points, const Vectors& normals, double spacing)
      : points_(points), normals_(normals), spacing_(spacing) {
    for (std::size_t v = 0; v < points.size(); ++v) {
      centre_ += points[v] / static_cast<double>(points.size());
      front_ += normals_[v];
    }
    if (front_.norm() > 0) front_.normalize();
    across_ = front_.unitOrthogonal();
    up_ = front_.cross(across_);
  }

  MirrorPlane run() const {
    const std::size_t coarse = 1 + points_.size() / 64;  // enough points to find the region
    State best;
    for (int step = 0; step < 24; ++step) {
      for (int shift = -1; shift <= 1; ++shift) {
        best = std::min(best, at({step * std::numbers::pi / 24, 0.0, shift * spacing_}, coarse));
      }
    }
    best = at(best.parameters);
    // Coordinate descent: turn in the face's plane, tilt out of it, shift.
    std::array<double, 3> step{std::numbers::pi / 48, std::numbers::pi / 48, 0.5 * spacing_};
    for (int round = 0; round < 6; ++round) {
      for (int k = 0; k < 3; ++k) {
        for (const double direction : {1.0, -1.0}) {
          State next = best;
          next.parameters[k] += direction * step[k];
          best = std::min(best, at(next.parameters));
        }
        step[k] *= 0.6;
      }
    }
    return best.plane;
  }

 private:
  struct State {
    std::array<double, 3> parameters{};
    MirrorPlane plane;
    bool operator<(const State& o) const { return plane.error < o.plane.error; }
  };

  State at(const std::array<double, 3>& parameters, std::size_t stride = 1) const {
    State state{parameters, {}};
    const auto& [turn, tilt, shift] = parameters;
    const Eigen::Vector3d flat = std::cos(turn) * across_ + std::sin(turn) * up_;
    state.plane.normal = std::cos(tilt) * flat + std::sin(tilt) * front_;
    state.plane.offset = state.plane.normal.dot(centre_) + shift;
    state.plane.error = error(state.plane, stride);
    return state;
  }

  double error(const MirrorPlane& plane, std::size_t stride) const {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < points_.size(); i += stride, ++count) {
      const auto& p = points_[i];
      const Eigen::Vector3d q = plane.mirrored(p);
      double least = std::numeric_limits<double>::infinity();
      std::size_t nearest = 0;
      for (std::size_t v = 0; v < points_.size(); ++v) {
        const double d = (points_[v] - q).squaredNorm();
        if (d < least) {
          least = d;
          nearest = v;
        }
      }
      // Beside the marked region there is no surface to compare with.
      const bool outside = least > 2.25 * spacing_ * spacing_;
      const double distance = std::abs(normals_[nearest].dot(q - points_[nearest]));
      sum += outside ? 1.0 : std::min(1.0, distance / spacing_);
    }
    return sum / static_cast<double>(count);
  }

  const Vectors& points_;
  const Vectors& normals_;
  double spacing_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d front_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d across_, up_;
};

}  // namespace

MirrorPlane find_mirror_plane(const Vectors& points, const Vectors& normals, double spacing) {
  if (points.size() < 3 || spacing <= 0) return {};
  return MirrorSearch(points, normals, spacing).run();
}

}  // namespace kinemesh
