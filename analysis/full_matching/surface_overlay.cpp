#include "analysis/full_matching/surface_overlay.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace kinemesh {

namespace {

/// Where a point of a face lies on the sphere; not of unit length.
Eigen::Vector3d ray_of(const SurfacePoint& point, const ClosedSurface& closed,
                       const std::vector<Eigen::Vector3d>& sphere) {
  return position_of(point, *closed.topology, sphere);
}

SurfacePoint open(const SurfacePoint& point, const ClosedSurface& closed) {
  return point.valid() && !closed.filling_face(point.face) ? point : SurfacePoint{};
}

double root_area_of(const ClosedSurface& closed) {
  double doubled = 0.0;
  for (FaceIndex f = 0; f < closed.surface_faces; ++f) {
    const auto& [a, b, c] = closed.topology->faces()[f];
    const auto& p = closed.positions;
    doubled += (p[b] - p[a]).cross(p[c] - p[a]).norm();
  }
  return std::sqrt(doubled / 2.0);
}

/// Collects distances between points and what they have become.
class Distances {
 public:
  explicit Distances(const ClosedSurface& closed) : root_area_(root_area_of(closed)) {}
  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const double distance = (to - from).norm() / root_area_;
    sum_ += distance;
    result_.worst = std::max(result_.worst, distance);
    ++result_.points;
  }
  ThereAndBack result() {
    if (result_.points > 0) result_.mean = sum_ / static_cast<double>(result_.points);
    return result_;
  }

 private:
  double root_area_, sum_ = 0.0;
  ThereAndBack result_;
};

/// Corners and middle of every face of the open surface.
template <class Carry, class Return>
ThereAndBack of_faces(const ClosedSurface& closed, Carry&& there, Return&& back) {
  Distances distances(closed);
  constexpr double third = 1.0 / 3.0;
  for (FaceIndex f = 0; f < closed.surface_faces; ++f) {
    for (const std::array<double, 3>& weights :
         {std::array{1.0, 0.0, 0.0}, std::array{0.0, 1.0, 0.0}, std::array{0.0, 0.0, 1.0},
          std::array{third, third, third}}) {
      const SurfacePoint start{f, weights};
      const SurfacePoint image = there(start);
      if (!image.valid()) continue;
      const SurfacePoint end = back(image);
      if (!end.valid()) continue;
      distances.add(position_of(start, *closed.topology, closed.positions),
                    position_of(end, *closed.topology, closed.positions));
    }
  }
  return distances.result();
}

}  // namespace

SurfaceOverlay::SurfaceOverlay(ClosedSurface source, std::vector<Eigen::Vector3d> source_sphere,
                               ClosedSurface target, std::vector<Eigen::Vector3d> target_sphere)
    : source_(std::move(source), std::move(source_sphere)),
      target_(std::move(target), std::move(target_sphere)) {}

SurfacePoint SurfaceOverlay::to_closed_target(const SurfacePoint& of_source) const {
  return target_.locator.locate(ray_of(of_source, source_.surface, source_.sphere).normalized());
}

SurfacePoint SurfaceOverlay::to_closed_source(const SurfacePoint& of_target) const {
  return source_.locator.locate(ray_of(of_target, target_.surface, target_.sphere).normalized());
}

SurfacePoint SurfaceOverlay::to_target(const SurfacePoint& of_source) const {
  return of_source.valid() ? open(to_closed_target(of_source), target_.surface) : SurfacePoint{};
}

SurfacePoint SurfaceOverlay::to_source(const SurfacePoint& of_target) const {
  return of_target.valid() ? open(to_closed_source(of_target), source_.surface) : SurfacePoint{};
}

ThereAndBack there_and_back(const SurfaceOverlay& overlay) {
  const auto to_target = [&](const SurfacePoint& p) { return overlay.to_target(p); };
  const auto to_source = [&](const SurfacePoint& p) { return overlay.to_source(p); };
  const ThereAndBack a = of_faces(overlay.source(), to_target, to_source),
                     b = of_faces(overlay.target(), to_source, to_target);
  return {std::max(a.mean, b.mean), std::max(a.worst, b.worst), a.points + b.points};
}

ThereAndBack there_and_back(const SurfaceMap& forward, const SurfaceMap& reverse,
                            const ClosedSurface& source, const ClosedSurface& target) {
  Distances distances(source);
  for (VertexIndex v = 0; v < forward.points.size(); ++v) {
    const SurfacePoint& there = forward.points[v];
    if (!there.valid()) continue;
    Eigen::Vector3d back = Eigen::Vector3d::Zero();
    bool whole = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const SurfacePoint& corner = reverse.points[target.topology->faces()[there.face][c]];
      whole = whole && corner.valid();
      if (whole) back += there.weights[c] * position_of(corner, *source.topology, source.positions);
    }
    if (whole) distances.add(source.positions[v], back);
  }
  return distances.result();
}

}  // namespace kinemesh
