// Sources and targets inside faces and on edges.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "mesh/geodesics/window_propagation.h"

namespace kinemesh::geodesics {
namespace {

/// A weight below this puts a point on the edge, two of them on the vertex.
constexpr double snap = 1e-12;

/// The corner a point lies on, or −1.
int corner_of(const SurfacePoint& point) {
  for (int corner = 0; corner < 3; ++corner) {
    if (point.weights[corner] >= 1.0 - snap) return corner;
  }
  return -1;
}

/// The corner opposite the edge a point lies on, or −1.
int edge_opposite_of(const SurfacePoint& point) {
  for (int corner = 0; corner < 3; ++corner) {
    if (point.weights[corner] <= snap) return corner;
  }
  return -1;
}

}  // namespace

void WindowPropagation::place_source(const SurfacePoint& point, uint32_t index) {
  const int corner = corner_of(point);
  distances_.push_back(0.0);
  if (corner >= 0) {
    const VertexIndex v = mesh_.frame(3 * point.face + corner).ends[0];
    source_vertices_.push_back(v);
    reach(v, 0.0, -1.0, {});
    return;
  }
  source_vertices_.push_back(invalid_index);
  const auto origin = static_cast<uint32_t>(mesh_.vertex_count() + index);
  spots_.push_back({point.face, index, true, point.weights});
  start_in_face(point, origin);
  const int opposite = edge_opposite_of(point);
  if (opposite < 0) return;
  const HalfedgeIndex edge = 3 * point.face + Topology::next(opposite);
  const HalfedgeIndex twin = mesh_.twin(edge);
  if (twin == invalid_index) return;
  SurfacePoint other;
  other.face = twin / 3;
  other.weights[twin % 3] = point.weights[Topology::next(edge) % 3];
  other.weights[Topology::next(twin) % 3] = point.weights[edge % 3];
  spots_.push_back({other.face, index, true, other.weights});
  start_in_face(other, origin);
}

void WindowPropagation::start_in_face(const SurfacePoint& point, uint32_t origin) {
  for (HalfedgeIndex h = 3 * point.face; h < 3 * point.face + 3; ++h) {
    const Frame& frame = mesh_.frame(h);
    const Eigen::Vector2d p = mesh_.in_frame(h, point.weights);
    reach(frame.ends[0], p.norm(), mesh_.corner_start(h) + std::atan2(p.y(), p.x()),
          {0.0, 0.0, invalid_index, origin});
    const bool on_edge = point.weights[Topology::previous(h) % 3] <= snap;
    if (on_edge || mesh_.twin(h) == invalid_index) continue;
    push({0.0, frame.length, frame.length - p.x(), p.y(), 0.0, mesh_.twin(h), origin}, 0.0);
  }
}

void WindowPropagation::place_spots(std::span<const SurfacePoint> targets) {
  target_distances_.assign(targets.size(), infinity);
  target_arrivals_.assign(targets.size(), {});
  for (uint32_t t = 0; t < targets.size(); ++t) {
    spots_.push_back({targets[t].face, t, false, targets[t].weights});
  }
  std::sort(spots_.begin(), spots_.end(), [](const Spot& a, const Spot& b) {
    return std::tie(a.face, a.is_source, a.index) < std::tie(b.face, b.is_source, b.index);
  });
  for (const Spot& spot : spots_) spotted_faces_[spot.face] = 1;
}

bool WindowPropagation::meets_source(const Window& w) {
  // No pencil may pass over a source: "one angle, one split" counts on it.
  const FaceIndex face = w.halfedge / 3;
  const double tolerance = end_tolerance * mesh_.frame(w.halfedge).length;
  auto spot = std::lower_bound(spots_.begin(), spots_.end(), face,
                               [](const Spot& s, FaceIndex f) { return s.face < f; });
  for (; spot != spots_.end() && spot->face == face; ++spot) {
    if (!spot->is_source) continue;
    const Eigen::Vector2d p = mesh_.in_frame(w.halfedge, spot->weights);
    const double crossing = w.x + (p.x() - w.x) * w.y / (w.y + p.y());
    if (!(crossing > w.low + tolerance && crossing < w.high - tolerance)) continue;
    for (const bool lower : {true, false}) {
      Window part = w;
      (lower ? part.high : part.low) = crossing;
      push(part, w.offset);
    }
    return true;
  }
  return false;
}

void WindowPropagation::reach_target(uint32_t target, double distance,
                                     const GeodesicArrival& arrival) {
  if (!(distance < target_distances_[target])) return;
  target_distances_[target] = distance;
  target_arrivals_[target] = arrival;
}

void WindowPropagation::reach_targets(const Window& w) {
  const FaceIndex face = w.halfedge / 3;
  const double tolerance = end_tolerance * mesh_.frame(w.halfedge).length;
  auto spot = std::lower_bound(spots_.begin(), spots_.end(), face,
                               [](const Spot& s, FaceIndex f) { return s.face < f; });
  for (; spot != spots_.end() && spot->face == face; ++spot) {
    if (spot->is_source) continue;
    const Eigen::Vector2d p = mesh_.in_frame(w.halfedge, spot->weights);
    const double crossing = w.x + (p.x() - w.x) * w.y / (w.y + p.y());
    if (!(crossing >= w.low - tolerance && crossing <= w.high + tolerance)) continue;
    reach_target(spot->index, w.offset + std::hypot(p.x() - w.x, p.y() + w.y),
                 {w.x, w.y, w.halfedge, w.origin});
  }
}

void WindowPropagation::finish_targets(std::span<const SurfacePoint> targets) {
  for (uint32_t t = 0; t < targets.size(); ++t) {
    const FaceIndex face = targets[t].face;
    for (HalfedgeIndex h = 3 * face; h < 3 * face + 3; ++h) {
      const VertexIndex v = mesh_.frame(h).ends[0];
      reach_target(t, distances_[v] + mesh_.in_frame(h, targets[t].weights).norm(),
                   {0.0, 0.0, invalid_index, v});
    }
    const Eigen::Vector2d p = mesh_.in_frame(3 * face, targets[t].weights);
    for (const Spot& spot : spots_) {
      if (!spot.is_source || spot.face != face) continue;
      reach_target(
          t, (mesh_.in_frame(3 * face, spot.weights) - p).norm(),
          {0.0, 0.0, invalid_index, static_cast<uint32_t>(mesh_.vertex_count() + spot.index)});
    }
  }
}

}  // namespace kinemesh::geodesics
