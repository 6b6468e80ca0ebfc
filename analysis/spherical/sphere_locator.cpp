#include "analysis/spherical/sphere_locator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/spherical/orientation.h"

namespace kinemesh {

SphereLocator::SphereLocator(const Topology& topology, std::span<const Eigen::Vector3d> points)
    : topology_(topology), points_(points) {
  resolution_ = static_cast<std::size_t>(
      std::clamp(std::sqrt(static_cast<double>(topology.face_count()) / 48.0), 1.0, 128.0));
  cells_.assign(6 * resolution_ * resolution_, invalid_index);
  for (FaceIndex f = 0; f < topology.face_count(); ++f) {
    const auto& [a, b, c] = topology.faces()[f];
    cells_[cell_of((points[a] + points[b] + points[c]).normalized())] = f;
  }
  FaceIndex last = 0;  // empty cells take what was nearest in order; the walk does the rest
  for (FaceIndex& cell : cells_) {
    if (cell == invalid_index) cell = last;
    last = cell;
  }
}

std::size_t SphereLocator::cell_of(const Eigen::Vector3d& p) const {
  Eigen::Index axis = 0;
  const double size = p.cwiseAbs().maxCoeff(&axis);
  const double n = static_cast<double>(resolution_);
  const auto part = [&](double x) {
    return static_cast<std::size_t>(std::clamp((x / size + 1.0) / 2.0 * n, 0.0, n - 1.0));
  };
  const auto side = static_cast<std::size_t>(2 * axis + (p[axis] < 0.0 ? 1 : 0));
  return (side * resolution_ + part(p[(axis + 1) % 3])) * resolution_ + part(p[(axis + 2) % 3]);
}

double SphereLocator::side(HalfedgeIndex h, const Eigen::Vector3d& p) const {
  const Eigen::Vector3d &a = points_[topology_.from(h)], &b = points_[topology_.to(h)];
  return (p - a).dot(a.cross(b - a));
}

bool SphereLocator::walk(const Eigen::Vector3d& p, FaceIndex& face) const {
  const std::size_t most =
      64 + 4 * static_cast<std::size_t>(std::sqrt(static_cast<double>(topology_.face_count())));
  HalfedgeIndex came = invalid_index;
  uint32_t turn = 0x9E3779B9U;
  for (std::size_t step = 0; step < most; ++step) {
    // The order in which the sides are asked varies: a fixed one may walk in circles.
    turn = turn * 1664525U + 1013904223U;
    HalfedgeIndex leave = invalid_index;
    for (uint32_t k = 0; k < 3 && leave == invalid_index; ++k) {
      const HalfedgeIndex h = 3 * face + (k + (turn >> 16)) % 3;
      if (h != came && side(h, p) < 0.0) leave = h;
    }
    if (leave == invalid_index) return true;
    came = topology_.twin(leave);
    if (came == invalid_index) return false;
    face = came / 3;
  }
  return false;
}

FaceIndex SphereLocator::search_all(const Eigen::Vector3d& p) const {
  FaceIndex best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (FaceIndex f = 0; f < topology_.face_count(); ++f) {
    const auto& [a, b, c] = topology_.faces()[f];
    if (p.dot(points_[a]) < -0.5 && p.dot(points_[b]) < -0.5) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const HalfedgeIndex h : {3 * f, 3 * f + 1, 3 * f + 2}) {
      const double length = (points_[topology_.from(h)] - points_[topology_.to(h)]).norm();
      least = std::min(least, side(h, p) / length);
    }
    if (least > most) {
      most = least;
      best = f;
    }
  }
  return best;
}

SurfacePoint SphereLocator::weigh(FaceIndex face, const Eigen::Vector3d& p) const {
  // Weight of a corner: det of the opposite side with p, over the sum.
  SurfacePoint point{.face = face};
  double sum = 0.0;
  for (HalfedgeIndex k = 0; k < 3; ++k) {
    const double weight = std::max(0.0, side(3 * face + (k + 1) % 3, p));
    point.weights[k] = weight;
    sum += weight;
  }
  if (!(sum > 0.0)) {
    point.weights = {1.0, 0.0, 0.0};
    return point;
  }
  for (double& weight : point.weights) weight /= sum;
  return point;
}

SurfacePoint SphereLocator::locate(const Eigen::Vector3d& p, FaceIndex hint) const {
  FaceIndex face = hint == invalid_index ? cells_[cell_of(p)] : hint;
  if (walk(p, face)) return weigh(face, p);
  return weigh(search_all(p), p);
}

}  // namespace kinemesh
