#include "mesh/formats/faces.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace kinemesh {
namespace {

constexpr std::size_t largest_clipped = 1000;

using Points2 = std::vector<Eigen::Vector2d>;

/// The corners in the polygon's mean plane, counter-clockwise (Newell's normal).
Points2 flattened(std::span<const VertexIndex> corners, const float* positions) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(corners.size());
  for (const VertexIndex v : corners) {
    points.push_back(
        Eigen::Map<const Eigen::Vector3f>(positions + 3 * std::size_t{v}).cast<double>());
  }
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d a = points[i] - points[0];
    normal += a.cross(points[(i + 1) % points.size()] - points[0]);
  }
  const double length = normal.norm();
  normal = length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d x = normal.unitOrthogonal();
  const Eigen::Vector3d y = normal.cross(x);
  Points2 flat;
  flat.reserve(points.size());
  for (const Eigen::Vector3d& p : points) {
    flat.emplace_back(x.dot(p - points[0]), y.dot(p - points[0]));
  }
  return flat;
}

double twice_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

bool is_convex(const Points2& p) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (twice_area(p[i], p[(i + 1) % p.size()], p[(i + 2) % p.size()]) < 0) return false;
  }
  return true;
}

/// True when the corner `i` of the remaining polygon can be cut off: convex, and no other corner
/// inside the triangle.
bool is_ear(const Points2& p, const std::vector<std::size_t>& left, std::size_t i) {
  const std::size_t n = left.size();
  const std::size_t before = left[(i + n - 1) % n], at = left[i], after = left[(i + 1) % n];
  if (twice_area(p[before], p[at], p[after]) <= 0) return false;
  for (const std::size_t other : left) {
    if (other == before || other == at || other == after) continue;
    if (twice_area(p[before], p[at], p[other]) >= 0 && twice_area(p[at], p[after], p[other]) >= 0 &&
        twice_area(p[after], p[before], p[other]) >= 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

void triangulate_polygon(std::span<const VertexIndex> corners, const float* positions,
                         std::vector<Triangle>& out) {
  std::vector<std::size_t> left(corners.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  if (corners.size() > 3 && corners.size() <= largest_clipped) {
    const Points2 flat = flattened(corners, positions);
    if (!is_convex(flat)) {
      while (left.size() > 3) {
        std::size_t i = 0;
        while (i < left.size() && !is_ear(flat, left, i)) ++i;
        if (i == left.size()) break;  // crosses itself: the rest becomes a fan
        const std::size_t n = left.size();
        out.push_back(
            {corners[left[(i + n - 1) % n]], corners[left[i]], corners[left[(i + 1) % n]]});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i) {
    out.push_back({corners[left[0]], corners[left[i]], corners[left[i + 1]]});
  }
}

void FaceCollector::add(std::span<const VertexIndex> corners) {
  if (corners.size() == 3) {
    triangles_.push_back({corners[0], corners[1], corners[2]});
  } else if (corners.size() < 3) {
    ++dropped_;
  } else {
    polygons_.push_back({triangles_.size(), corners_.size(), corners.size()});
    corners_.insert(corners_.end(), corners.begin(), corners.end());
  }
}

std::size_t FaceCollector::first_out_of_range(std::size_t vertex_count) const {
  const auto outside = [vertex_count](VertexIndex v) { return v >= vertex_count; };
  std::size_t first = size();
  for (std::size_t i = 0, p = 0; i < triangles_.size(); ++i) {
    const Triangle& t = triangles_[i];
    if (!outside(t[0]) && !outside(t[1]) && !outside(t[2])) continue;
    while (p < polygons_.size() && polygons_[p].before <= i) ++p;
    first = i + p;
    break;
  }
  for (std::size_t p = 0; p < polygons_.size() && polygons_[p].before + p < first; ++p) {
    const auto begin = corners_.begin() + static_cast<std::ptrdiff_t>(polygons_[p].begin);
    if (std::any_of(begin, begin + static_cast<std::ptrdiff_t>(polygons_[p].size), outside)) {
      return polygons_[p].before + p;
    }
  }
  return first;
}

void FaceCollector::finish(MeshData& data) {
  data.polygons += polygons_.size();
  data.dropped_faces += dropped_;
  if (polygons_.empty()) {
    data.faces = std::move(triangles_);
    return;
  }
  data.faces.clear();
  data.faces.reserve(triangles_.size() + corners_.size() - 2 * polygons_.size());
  std::size_t taken = 0;
  for (const Polygon& polygon : polygons_) {
    data.faces.insert(data.faces.end(), triangles_.begin() + static_cast<std::ptrdiff_t>(taken),
                      triangles_.begin() + static_cast<std::ptrdiff_t>(polygon.before));
    taken = polygon.before;
    triangulate_polygon(std::span(corners_).subspan(polygon.begin, polygon.size),
                        data.positions.data(), data.faces);
  }
  data.faces.insert(data.faces.end(), triangles_.begin() + static_cast<std::ptrdiff_t>(taken),
                    triangles_.end());
}

}  // namespace kinemesh
