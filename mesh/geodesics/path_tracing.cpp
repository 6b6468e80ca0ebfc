#include "mesh/geodesics/path_tracing.h"

#include <algorithm>
#include <cmath>

namespace kinemesh::geodesics {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A point on the way, with the origin, both in the frame of a halfedge that the way back enters.
struct Position {
  HalfedgeIndex halfedge;
  Eigen::Vector2d here, origin;
};

/// Whether the origin lies in the face of the halfedge, at the place where it should be.
bool at_origin(const UnfoldedMesh& mesh, const Position& p, const SurfacePoint& origin,
               VertexIndex vertex) {
  const Frame& frame = mesh.frame(p.halfedge);
  const double tolerance = 1e-6 * (frame.length + frame.sides[0].length + frame.sides[1].length);
  Eigen::Vector2d place;
  if (vertex != invalid_index) {
    if (frame.apex == vertex) {
      place = {frame.px, frame.py};
    } else if (frame.ends[0] == vertex) {
      place = {0.0, 0.0};
    } else if (frame.ends[1] == vertex) {
      place = {frame.length, 0.0};
    } else {
      return false;
    }
  } else {
    if (mesh.original_face(p.halfedge / 3) != origin.face) return false;
    place = mesh.in_frame(p.halfedge, origin.weights);
  }
  return (place - p.origin).norm() <= tolerance;
}

/// Leaves the face of p.halfedge towards the origin. False at a border.
bool next_face(const UnfoldedMesh& mesh, Position& p, std::vector<SurfacePoint>& points) {
  const Frame& frame = mesh.frame(p.halfedge);
  const Eigen::Vector2d apex(frame.px, frame.py), way = p.origin - p.here;
  const bool left = cross(way, apex - p.here) <= 0.0;  // the apex lies right of the way
  const HalfedgeIndex entered = left ? frame.beyond[0] : frame.beyond[1];
  if (entered == invalid_index) return false;
  const Eigen::Vector2d corner = left ? Eigen::Vector2d::Zero() : apex;
  const Eigen::Vector2d axis = left ? Eigen::Vector2d(frame.sides[0].cos, frame.sides[0].sin)
                                    : Eigen::Vector2d(frame.sides[1].cos, -frame.sides[1].sin);
  const double length = left ? frame.sides[0].length : frame.sides[1].length;
  const double slope = cross(axis, way);
  if (!(slope > 0.0)) return false;  // the way leads back
  const double along = std::clamp(cross(p.here - corner, way) / slope, 0.0, length);
  points.push_back(mesh.to_surface_point(p.halfedge, corner + along * axis));
  const Eigen::Vector2d to_origin = p.origin - corner;
  p = {entered, {along, 0.0}, {axis.dot(to_origin), cross(axis, to_origin)}};
  return true;
}

/// The apex of the face when it lies on the way, or invalid_index.
VertexIndex apex_on_way(const Frame& frame, const Position& p) {
  const Eigen::Vector2d way = p.origin - p.here,
                        to_apex = Eigen::Vector2d(frame.px, frame.py) - p.here;
  return std::abs(cross(way, to_apex)) <= 1e-9 * frame.sides[0].length * way.norm() ? frame.apex
                                                                                    : invalid_index;
}

TraceEnd at_vertex(VertexIndex v) { return {false, {v, invalid_index, invalid_index}}; }

TraceEnd lost_in(const Frame& frame) {
  return {false, {frame.ends[0], frame.ends[1], frame.apex}, true};
}

}  // namespace

TraceEnd trace_straight(const UnfoldedMesh& mesh, const Eigen::Vector2d& start,
                        const GeodesicArrival& arrival, const SurfacePoint& origin,
                        VertexIndex vertex, std::vector<SurfacePoint>& points) {
  const Frame& first = mesh.frame(arrival.halfedge);
  const double depth = arrival.y + start.y();
  const double crossing =
      depth > 0.0 ? start.x() + (arrival.x - start.x()) * start.y() / depth : start.x();
  if (!(crossing > 1e-9 * first.length)) return at_vertex(first.ends[0]);
  if (!(crossing < (1.0 - 1e-9) * first.length)) return at_vertex(first.ends[1]);
  points.push_back(mesh.to_surface_point(arrival.halfedge, {crossing, 0.0}));
  Position p{mesh.twin(arrival.halfedge),
             {first.length - crossing, 0.0},
             {first.length - arrival.x, arrival.y}};
  for (std::size_t steps = 0; steps < 4 * mesh.face_count() + 16; ++steps) {
    const Frame& frame = mesh.frame(p.halfedge);
    if (at_origin(mesh, p, origin, vertex)) {
      points.push_back(origin);
      return {true, {}};
    }
    const VertexIndex passed = apex_on_way(frame, p);
    if (passed != invalid_index) return at_vertex(passed);
    if (!next_face(mesh, p, points)) return lost_in(frame);
  }
  return lost_in(first);
}

}  // namespace kinemesh::geodesics
