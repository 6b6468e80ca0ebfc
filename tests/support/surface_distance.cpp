#include "tests/support/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace kinemesh::test {

SurfaceDistance::SurfaceDistance(const TrueSurface& surface)
    : surface_(surface), labels_(surface.positions.size()) {}

SurfaceDistance::Label SurfaceDistance::along(VertexIndex a, VertexIndex c) const {
  Label label = labels_[a];
  if (surface_.topology->is_boundary_vertex(a)) {
    label.root = a;
    label.bend = label.distance;
  }
  label.distance += (surface_.positions[a] - surface_.positions[c]).norm();
  return label;
}

/// Distance of the apex of a triangle over the base from 0 to `length`, whose ends lie `da` and
/// `db` from a source on the other side; unreached when the straight path misses the base.
double SurfaceDistance::unfold(double da, double db, double length, double cx, double cy) {
  const double sx = (da * da - db * db + length * length) / (2 * length);
  const double sy = std::sqrt(std::max(0.0, da * da - sx * sx));
  const double crossing = sy + cy > 0 ? sx + (cx - sx) * sy / (sy + cy) : sx;
  const double slack = 1e-9 * length;
  if (crossing < -slack || crossing > length + slack) return unreached;
  return std::hypot(cx - sx, cy + sy);
}

/// Distance of c through the edge a–b of their triangle, from the source's image in its plane.
SurfaceDistance::Label SurfaceDistance::across(VertexIndex a, VertexIndex b, VertexIndex c) const {
  const Label &la = labels_[a], &lb = labels_[b];
  const auto& p = surface_.positions;
  const Eigen::Vector3d ab = p[b] - p[a], ac = p[c] - p[a];
  const double length = ab.norm();
  Label best = along(a, c);
  const auto consider = [&](const Label& label) {
    if (label.distance < best.distance) best = label;
  };
  consider(along(b, c));
  if (length == 0) return best;
  const double cx = ac.dot(ab) / length;
  const double cy = std::sqrt(std::max(0.0, ac.squaredNorm() - cx * cx));
  const auto from_root = [&](double da, double db, double bend, VertexIndex root) {
    consider({bend + unfold(da, db, length, cx, cy), bend, root});
  };
  if (la.root == lb.root) {
    from_root(la.distance - la.bend, lb.distance - lb.bend, la.bend, la.root);
    return best;
  }
  // At the border of a shadow: one path is straight and the other bent. Both ends count as seen
  // straight, and as seen from the bend, when that is near enough for a chord to be its distance.
  from_root(la.distance, lb.distance, 0, invalid_index);
  constexpr double near_mm = 15;
  for (const Label* bent : {&la, &lb}) {
    if (bent->root == invalid_index) continue;
    const double da = (p[a] - p[bent->root]).norm(), db = (p[b] - p[bent->root]).norm();
    if (std::max(da, db) < near_mm) from_root(da, db, bent->bend, bent->root);
  }
  return best;
}

void SurfaceDistance::offer(VertexIndex v, const Label& label, double radius) {
  Label& old = labels_[v];
  if (label.distance > radius || label.distance >= old.distance - 1e-9) return;
  if (old.distance == unreached) touched_.push_back(v);
  old = label;
  queue_.emplace_back(label.distance, v);
  std::push_heap(queue_.begin(), queue_.end(), std::greater<>());
}

void SurfaceDistance::relax_around(VertexIndex v, double radius) {
  for (const FaceIndex f : surface_.topology->faces_of(v)) {
    const Triangle& face = surface_.topology->faces()[f];
    const int corner = face[0] == v ? 0 : face[1] == v ? 1 : 2;
    const VertexIndex a = face[(corner + 1) % 3], b = face[(corner + 2) % 3];
    const bool has_a = labels_[a].distance < unreached, has_b = labels_[b].distance < unreached;
    offer(b, has_a ? across(v, a, b) : along(v, b), radius);
    offer(a, has_b ? across(v, b, a) : along(v, a), radius);
  }
}

std::vector<SurfaceDistance::VertexDistance> SurfaceDistance::from(const SurfacePoint& source,
                                                                   double radius) {
  const Eigen::Vector3d p = position_of(source, *surface_.topology, surface_.positions);
  for (const VertexIndex v : surface_.topology->faces()[source.face]) {
    offer(v, {(surface_.positions[v] - p).norm(), 0, invalid_index}, radius);
  }
  while (!queue_.empty()) {
    std::pop_heap(queue_.begin(), queue_.end(), std::greater<>());
    const auto [distance, v] = queue_.back();
    queue_.pop_back();
    if (distance <= labels_[v].distance) relax_around(v, radius);
  }
  std::vector<VertexDistance> result;
  result.reserve(touched_.size());
  for (const VertexIndex v : touched_) {
    result.push_back({v, labels_[v].distance});
    labels_[v] = Label{};
  }
  touched_.clear();
  return result;
}

}  // namespace kinemesh::test
