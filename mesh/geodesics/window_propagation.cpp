#include "mesh/geodesics/window_propagation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/error.h"

namespace kinemesh::geodesics {
namespace {

/// A path must be longer than another by this factor to count as dominated: rounding must never
/// remove both of two equal paths.
constexpr double clearly = 1.0 + 1e-12;
/// Windows narrower than this (over the edge's length) have no inside left.
constexpr double least_width = 1e-14;
/// Rounding turns sectors by less than this angle (radians); they are widened by it.
constexpr double sector_tolerance = 1e-9;
/// Edges within this angle of going straight on at a vertex are tried: a path along an edge is
/// never wrong, only perhaps not the shortest.
constexpr double straight_tolerance = 2e-5;

double length_of(double x, double y) { return std::sqrt(x * x + y * y); }

/// Whether the root of `square` is above `bound`.
bool longer(double square, double bound) { return bound < 0.0 || square > bound * bound; }

/// Distance from the window's origin to the nearest point of its interval.
double nearest_point(const Window& w) {
  const double beside = w.x < w.low ? w.low - w.x : w.x > w.high ? w.x - w.high : 0.0;
  return w.offset + length_of(beside, w.y);
}

}  // namespace

WindowPropagation::WindowPropagation(const UnfoldedMesh& mesh)
    : mesh_(mesh),
      distances_(mesh.vertex_count(), infinity),
      directions_(mesh.vertex_count(), 0.0),
      arrivals_(mesh.vertex_count()),
      occupants_(3 * mesh.face_count()),
      spotted_faces_(mesh.face_count(), 0) {}

void WindowPropagation::forget() {
  distances_.resize(mesh_.vertex_count());
  for (const VertexIndex v : reached_) distances_[v] = infinity;
  for (const HalfedgeIndex h : occupied_) occupants_[h] = {};
  for (const Spot& spot : spots_) spotted_faces_[spot.face] = 0;
  reached_.clear();
  occupied_.clear();
  spots_.clear();
  source_vertices_.clear();
  windows_ = 0;
  const double mean = mesh_.mean_length();
  queue_.reset(mean > 0.0 ? 0.5 * mean : 1.0);
}

void WindowPropagation::run(std::span<const SurfacePoint> sources,
                            std::span<const SurfacePoint> targets, double radius,
                            const RunContext* ctx) {
  forget();
  radius_ = radius;
  for (uint32_t s = 0; s < sources.size(); ++s) place_source(sources[s], s);
  place_spots(targets);
  has_spots_ = !spots_.empty();
  do {
    empty_queue(ctx);
  } while (reach_missed_vertices());
  finish_targets(targets);
}

void WindowPropagation::empty_queue(const RunContext* ctx) {
  while (queue_.take_bucket(bucket_)) {
    if (ctx != nullptr) ctx->check_cancelled();
    propagate_bucket();
    refuse_excess();
  }
}

/// No mesh with usable triangles comes near these figures (at 200,000 vertices some hundred windows
/// a face, and a hundredth of a window a face waiting).
void WindowPropagation::refuse_excess() const {
  const std::size_t faces = mesh_.face_count();
  if (queue_.waiting() < 1'000'000 + 32 * faces && windows_ < 10'000'000 + 10'000 * faces) return;
  throw NoResultError(
      {.what = "the triangles of the mesh are too thin for exact distances: rounding splits the "
               "paths without end",
       .remedy = "Merge vertices that all but coincide, or measure along edges (--method "
                 "dijkstra)"});
}

void WindowPropagation::reach(VertexIndex v, double distance, double direction,
                              const GeodesicArrival& arrival) {
  if (!(distance < distances_[v])) return;
  if (distances_[v] == infinity) reached_.push_back(v);
  distances_[v] = distance;
  directions_[v] = direction;
  arrivals_[v] = arrival;
  if (mesh_.kind(v) != VertexKind::convex || direction < 0.0) {
    push({0.0, 0.0, 0.0, 0.0, distance, invalid_index, v}, distance);
  }
}

void WindowPropagation::propagate_bucket() {
  constexpr std::size_t ahead = 8;  // frames take about as long to load as 8 windows to compute
  const std::size_t count = bucket_.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (i + ahead < count) mesh_.prefetch(bucket_[i + ahead].halfedge);
    const Window& window = bucket_[i];
    if (window.offset > distances_[window.origin]) continue;  // its origin is nearer by now
    if (window.halfedge == invalid_index) {
      bend_paths(window.origin, window.offset);
    } else {
      propagate(window);
    }
  }
}

inline void WindowPropagation::propagate(const Window& w) {
  ++windows_;
  const Frame& frame = mesh_.frame(w.halfedge);
  if (has_spots_ && spotted_faces_[w.halfedge / 3] != 0) {
    if (meets_source(w)) return;
    reach_targets(w);
  }
  const double along = frame.px - w.x, depth = w.y + frame.py, per_depth = 1.0 / depth;
  double crossing = w.x + along * (w.y * per_depth);
  bool left = crossing > w.low, right = crossing < w.high;
  const double tolerance =
      end_tolerance * frame.length + aside_tolerance * (along * along + depth * depth) * per_depth;
  if (crossing >= w.low - tolerance && crossing <= w.high + tolerance) {
    meet_apex(w, frame, crossing, tolerance, left, right);
    // A window that all but ends at the apex goes on up to it, so that its neighbour's end and its
    // own stay together.
    crossing = std::clamp(crossing, w.low, w.high);
    if (left && right) leave(w, frame, crossing, 1);
    if (!left && !right) return;
  }
  leave(w, frame, crossing, left ? 0 : 1);
}

void WindowPropagation::meet_apex(const Window& w, const Frame& frame, double crossing,
                                  double tolerance, bool& left, bool& right) {
  const double distance = w.offset + length_of(frame.px - w.x, frame.py + w.y);
  if (distance < distances_[frame.apex]) {
    const double within =
        std::atan2(frame.py * crossing, frame.py * frame.py - frame.px * (crossing - frame.px));
    reach(frame.apex, distance, mesh_.corner_start(Topology::previous(w.halfedge)) + within,
          {w.x, w.y, w.halfedge, w.origin});
  }
  Occupant& occupant = occupants_[w.halfedge];
  if (distance < occupant.distance) {
    if (occupant.distance == infinity) occupied_.push_back(w.halfedge);
    occupant = {distance, crossing};
  } else if (left && right && distance > occupant.distance * clearly &&
             std::abs(crossing - occupant.crossing) > tolerance) {
    (crossing < occupant.crossing ? right : left) = false;
  }
}

/// Hands on what leaves over one side. Lengths along the edge and the side count from the end that
/// they share, so that left and right are the same computation, without a branch that could be
/// mispredicted.
inline void WindowPropagation::leave(const Window& w, const Frame& frame, double crossing,
                                     unsigned side) {
  const FrameSide& s = frame.sides[side];
  const bool mirrored = side != 0;
  const double near = mirrored ? frame.length - w.high : w.low;
  const double far = mirrored ? frame.length - w.low : w.high;
  const double from = mirrored ? frame.length - w.x : w.x;
  const bool to_apex = mirrored ? crossing >= w.low : crossing <= w.high;
  const double x = from * s.cos - w.y * s.sin;
  const double y = from * s.sin + w.y * s.cos;
  const double low = near <= 0.0 ? 0.0 : near * w.y / (y - near * s.sin);
  const double high = to_apex ? s.length : std::min(s.length, far * w.y / (y - far * s.sin));
  const HalfedgeIndex beyond = frame.beyond[side];
  if (!(high - low > least_width * s.length) || beyond == invalid_index) return;
  // Squares are compared instead of distances.
  const double square_low = (low - x) * (low - x) + y * y;
  const double square_high = (high - x) * (high - x) + y * y;
  const double over_base = (distances_[frame.ends[side]] + high) * clearly - w.offset;
  const double over_apex = (distances_[frame.apex] + (s.length - low)) * clearly - w.offset;
  if (longer(square_high, over_base) || longer(square_low, over_apex)) return;
  const double aside = frame.length - low * s.cos, back = low * s.sin;
  const double behind =
      std::sqrt(square_low) + w.offset - distances_[frame.ends[1 - side]] * clearly;
  if (behind > 0.0 && behind * behind > (aside * aside + back * back) * clearly) return;
  const double square = x < low ? square_low : x > high ? square_high : y * y;
  const double key = w.offset + std::sqrt(square);
  push({mirrored ? s.length - high : low, mirrored ? s.length - low : high,
        mirrored ? s.length - x : x, y, w.offset, beyond, w.origin},
       key);
}

void WindowPropagation::bend_paths(VertexIndex v, double distance) {
  constexpr double pi = std::numbers::pi;
  if (mesh_.outgoing(v) == invalid_index) return;
  if (mesh_.kind(v) == VertexKind::irregular) {
    bend_everywhere(v, distance);
    return;
  }
  const double total = mesh_.total_angle(v), arrival = directions_[v];
  if (arrival < 0.0) {
    bend_into(v, 0.0, total, distance, true);
  } else if (mesh_.kind(v) == VertexKind::boundary) {
    // Only the sides within the surface must leave an angle of π.
    const double over = arrival + pi, under = arrival - pi;
    const bool opens_over = total - over > sector_tolerance, opens_under = under > sector_tolerance;
    bend_into(v, opens_over ? over - sector_tolerance : over, total, distance, opens_over);
    bend_into(v, 0.0, opens_under ? under + sector_tolerance : under, distance, opens_under);
  } else {
    const bool flat = mesh_.kind(v) == VertexKind::flat;
    const double widening = flat ? 0.0 : sector_tolerance;
    double from = arrival + pi - widening, to = arrival + total - pi + widening;
    if (from >= total) {
      from -= total;
      to -= total;
    }
    bend_into(v, from, std::min(to, total), distance, !flat);
    if (to > total) bend_into(v, 0.0, to - total, distance, !flat);
  }
}

/// Along the edges of a sector and, with `windows`, between them.
void WindowPropagation::bend_into(VertexIndex v, double from, double to, double distance,
                                  bool windows) {
  const HalfedgeIndex first = mesh_.outgoing(v);
  const bool closed = mesh_.kind(v) != VertexKind::boundary;
  const double turn = closed ? mesh_.total_angle(v) : 0.0;
  const auto near_sector = [&](double angle) {
    return angle >= from - straight_tolerance && angle <= to + straight_tolerance;
  };
  HalfedgeIndex h = first;
  do {
    const double start = mesh_.corner_start(h), angle = mesh_.corner_angle(h);
    if (windows && start < to && start + angle > from) {
      send_window(h, from - start, to - start, v, distance);
    }
    if (near_sector(start) ||
        (closed && (near_sector(start + turn) || near_sector(start - turn)))) {
      const Frame& frame = mesh_.frame(h);
      send_along_edge(v, frame.ends[1], distance + frame.length, direction_back_along(h));
    }
    const HalfedgeIndex border = Topology::previous(h);
    h = mesh_.twin(border);
    if (h == invalid_index && near_sector(start + angle)) {
      const Frame& frame = mesh_.frame(border);
      send_along_edge(v, frame.ends[0], distance + frame.length, mesh_.corner_start(border));
    }
  } while (h != invalid_index && h != first);
}

void WindowPropagation::bend_everywhere(VertexIndex v, double distance) {
  for (const HalfedgeIndex h : mesh_.corners_of_irregular(v)) {
    send_window(h, 0.0, mesh_.corner_angle(h), v, distance);
    const Frame& frame = mesh_.frame(h);
    send_along_edge(v, frame.ends[1], distance + frame.length, direction_back_along(h));
    const HalfedgeIndex in = Topology::previous(h);
    const Frame& incoming = mesh_.frame(in);
    send_along_edge(v, incoming.ends[0], distance + incoming.length, mesh_.corner_start(in));
  }
}

void WindowPropagation::send_along_edge(VertexIndex from, VertexIndex to, double distance,
                                        double direction) {
  reach(to, distance, direction, {0.0, 0.0, invalid_index, from});
}

double WindowPropagation::direction_back_along(HalfedgeIndex h) const {
  const HalfedgeIndex twin = mesh_.twin(h);
  if (twin != invalid_index) return mesh_.corner_start(twin);
  const HalfedgeIndex next = Topology::next(h);
  return mesh_.corner_start(next) + mesh_.corner_angle(next);
}

void WindowPropagation::send_window(HalfedgeIndex corner, double from, double to, VertexIndex v,
                                    double distance) {
  const HalfedgeIndex opposite = Topology::next(corner), entered = mesh_.twin(opposite);
  if (entered == invalid_index) return;
  const Frame& frame = mesh_.frame(opposite);  // v is its apex
  const double square = frame.px * frame.px + frame.py * frame.py;
  const auto hit = [&](double angle) {
    const double s = std::sin(angle), c = std::cos(angle);
    return square * s / (frame.px * s + frame.py * c);
  };
  const double start = from <= 0.0 ? 0.0 : hit(from);
  const double end = to >= mesh_.corner_angle(corner) ? frame.length : hit(to);
  const Window window{frame.length - std::min(end, frame.length),
                      frame.length - start,
                      frame.length - frame.px,
                      frame.py,
                      distance,
                      entered,
                      v};
  if (!(window.high - window.low > least_width * frame.length)) return;
  push(window, nearest_point(window));
}

}  // namespace kinemesh::geodesics
