#include "report/camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace kinemesh {
namespace {

using Eigen::Vector3f;

struct NormalSum {
  Vector3f sum = Vector3f::Zero();
  float area = 0.0F;
};

NormalSum normals_of(const Topology& topology, const FrameView& positions) {
  NormalSum total;
  for (const Triangle& t : topology.faces()) {
    const Vector3f a = positions.row(t[0]);
    const Vector3f n =
        (positions.row(t[1]).transpose() - a).cross(positions.row(t[2]).transpose() - a);
    if (!n.allFinite()) continue;
    total.sum += 0.5F * n;
    total.area += 0.5F * n.norm();
  }
  return total;
}

std::optional<BodyAxes> axes_from(const Vector3f& front, const Vector3f& up) {
  const Vector3f level = front - up * up.dot(front);
  if (!(level.norm() > 1e-3F)) return std::nullopt;
  return BodyAxes{level.normalized(), up, true};
}

// Mean distance from each mirrored point to the nearest point, at most 400 points compared.
double asymmetry(const std::vector<Vector3f>& points, const Vector3f& right) {
  Vector3f centre = Vector3f::Zero();
  for (const Vector3f& p : points) centre += p / static_cast<float>(points.size());
  const std::size_t step = points.size() / 400 + 1;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); i += step, ++count) {
    const Vector3f mirrored = points[i] - 2.0F * right.dot(points[i] - centre) * right;
    float nearest = std::numeric_limits<float>::max();
    for (std::size_t k = 0; k < points.size(); k += step) {
      nearest = std::min(nearest, (points[k] - mirrored).squaredNorm());
    }
    sum += std::sqrt(nearest);
  }
  return sum / static_cast<double>(std::max<std::size_t>(count, 1));
}

BodyAxes open_axes(const Vector3f& front, const FrameView& positions) {
  std::vector<Vector3f> points = points_of(positions);
  std::erase_if(points, [](const Vector3f& p) { return !p.allFinite(); });
  BodyAxes best;
  double least = std::numeric_limits<double>::max();
  // y and z first: on a tie they are the usual ones.
  for (const int axis : {1, 2, 0}) {
    const Vector3f up = Vector3f::Unit(axis);
    if (std::abs(front.normalized().dot(up)) > 0.8F) continue;
    const auto axes = axes_from(front, up);
    if (!axes) continue;
    const double score = asymmetry(points, axes->up.cross(axes->front));
    if (score < 0.95 * least) {
      least = score;
      best = *axes;
    }
  }
  return best;
}

// The level direction along which the body is thinnest: from there it shows its broad side.
BodyAxes closed_axes(const Vector3f& up, const FrameView& positions) {
  const Vector3f side = std::abs(up.x()) < 0.9F ? Vector3f::UnitX() : Vector3f::UnitZ();
  const Vector3f a = (side - up * up.dot(side)).normalized();
  const Vector3f b = up.cross(a);
  BodyAxes best{b, up, false};
  float least = std::numeric_limits<float>::max();
  for (int degrees = 0; degrees < 180; degrees += 15) {
    const float angle = static_cast<float>(degrees) * static_cast<float>(M_PI) / 180.0F;
    const Vector3f front = std::cos(angle) * b + std::sin(angle) * a;
    const Eigen::VectorXf along = positions * front;
    const float extent = along.maxCoeff() - along.minCoeff();
    if (extent < 0.99F * least) {
      least = extent;
      best.front = front;
    }
  }
  return best;
}

}  // namespace

BodyAxes estimate_axes(const Topology& topology, const FrameView& positions,
                       const std::optional<Vector3f>& up) {
  const NormalSum normals = normals_of(topology, positions);
  const bool open = normals.area > 0.0F && normals.sum.norm() > 0.15F * normals.area;
  if (up && up->norm() > 0.0F) {
    const Vector3f unit = up->normalized();
    if (open) {
      if (const auto axes = axes_from(normals.sum, unit)) return *axes;
    }
    return closed_axes(unit, positions);
  }
  if (open) return open_axes(normals.sum, positions);
  return normals.area > 0.0F ? closed_axes(Vector3f::UnitY(), positions) : BodyAxes{};
}

Eigen::Vector2d Camera::project(const Vector3f& point, double width, double height) const {
  const Eigen::Vector3d v = to_view(point).cast<double>();
  const double scale = height / view_height;
  return {0.5 * width + v.x() * scale, 0.5 * height - v.y() * scale};
}

Camera camera_for(View view, const BodyAxes& axes) {
  const Vector3f left = axes.up.cross(axes.front);  // the body's left
  Vector3f towards = axes.front;
  Vector3f up = axes.up;
  switch (view) {
    case View::front: break;
    case View::back: towards = -axes.front; break;
    case View::left: towards = left; break;
    case View::right: towards = -left; break;
    case View::top:
      towards = axes.up;
      up = -axes.front;
      break;
    case View::three_quarter:
      towards = (axes.front + 0.7F * left + 0.25F * axes.up).normalized();
      break;
  }
  Camera camera;
  const Vector3f right = up.cross(towards).normalized();
  camera.axes.row(0) = right;
  camera.axes.row(1) = towards.cross(right);
  camera.axes.row(2) = towards;
  return camera;
}

void aim(Camera& camera, std::span<const Vector3f> points, double aspect, double margin) {
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::max());
  Vector3f high = -low;
  for (const Vector3f& point : points) {
    if (!point.allFinite()) continue;
    const Vector3f v = camera.axes * point;
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  if (!(low.x() <= high.x())) return;
  const Vector3f size = high - low;
  camera.centre = camera.axes.transpose() * (0.5F * (low + high));
  const double height = std::max<double>(size.y(), size.x() / aspect);
  camera.view_height = static_cast<float>(std::max(height / (1.0 - 2.0 * margin), 1e-6));
}

std::vector<Vector3f> points_of(const FrameView& positions) {
  std::vector<Vector3f> points(static_cast<std::size_t>(positions.rows()));
  for (std::size_t v = 0; v < points.size(); ++v) {
    points[v] = positions.row(static_cast<Eigen::Index>(v));
  }
  return points;
}

}  // namespace kinemesh
