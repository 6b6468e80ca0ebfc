// Paths behind a field of distances, and the source each vertex belongs to.
#include <algorithm>
#include <string>

#include "config/error.h"
#include "mesh/geodesics/path_tracing.h"
#include "mesh/geodesics/solver_data.h"

namespace kinemesh {

void GeodesicSolver::Data::name_nearest_sources(GeodesicField& field) const {
  const std::size_t count = inner.size();
  field.nearest_source.assign(count, invalid_index);
  std::vector<VertexIndex> chain;
  for (VertexIndex v = 0; v < count; ++v) {
    if (field.distances[v] == unreachable) continue;
    chain.clear();
    VertexIndex at = v;
    uint32_t source = invalid_index;
    // An origin is always nearer to the source than what it reaches, so that chains end.
    while (source == invalid_index && field.arrivals[at].origin != invalid_index) {
      chain.push_back(at);
      const uint32_t origin = field.arrivals[at].origin;
      if (origin >= count) {
        source = origin - static_cast<uint32_t>(count);
      } else {
        at = mesh.original_vertex(origin);
        source = field.nearest_source[at];
      }
    }
    for (const VertexIndex passed : chain) field.nearest_source[passed] = source;
  }
}

GeodesicPath GeodesicSolver::Data::trace(const GeodesicField& field, GeodesicArrival arrival,
                                         double distance, const SurfacePoint& end,
                                         bool arrival_of_vertex) const {
  if (distance == unreachable) {
    throw NoResultError({.what = "no path leads from a source to the end point",
                         .remedy = "The mesh may have several pieces, or the end point lies beyond "
                                   "the radius of the search"});
  }
  const auto count = static_cast<uint32_t>(inner.size());
  GeodesicPath path;
  path.points.push_back(end);
  // A vertex is the apex of the frame it was reached in; a target lies somewhere in its face.
  bool at_vertex = arrival_of_vertex;
  for (std::size_t stretches = 0; stretches < 2 * inner.size() + 16; ++stretches) {
    if (arrival.origin == invalid_index) break;
    const bool at_source = arrival.origin >= count;
    const SurfacePoint origin =
        at_source ? field.sources.at(arrival.origin - count) : mesh.vertex_point(arrival.origin);
    VertexIndex next = at_source ? invalid_index : arrival.origin;
    if (arrival.halfedge == invalid_index) {
      path.points.push_back(origin);
    } else {
      const geodesics::Frame& frame = mesh.frame(arrival.halfedge);
      const Eigen::Vector2d start = at_vertex ? Eigen::Vector2d(frame.px, frame.py)
                                              : mesh.in_frame(arrival.halfedge, end.weights);
      const geodesics::TraceEnd traced =
          trace_straight(mesh, start, arrival, origin, next, path.points);
      if (!traced.at_origin) next = pass_vertex(field, traced, path.points);
    }
    if (next == invalid_index) {
      path.source = arrival.origin - count;
      std::reverse(path.points.begin(), path.points.end());
      measure(path);
      return path;
    }
    at_vertex = true;
    arrival = field.arrivals[mesh.original_vertex(next)];
  }
  throw InternalError("a shortest path could not be followed back to its source");
}

/// Appends the vertex through which the path goes on: of several, the one with the shortest way.
VertexIndex GeodesicSolver::Data::pass_vertex(const GeodesicField& field,
                                              const geodesics::TraceEnd& traced,
                                              std::vector<SurfacePoint>& points) const {
  const Eigen::Vector3d here = position_of(points.back(), *topology, positions);
  VertexIndex best = invalid_index;
  double least = unreachable;
  for (const VertexIndex v : traced.vertices) {
    if (v == invalid_index) continue;
    const VertexIndex original = mesh.original_vertex(v);
    const double length = field.distances[original] + (positions[original] - here).norm();
    if (!(length < least)) continue;
    best = v;
    least = length;
  }
  if (best == invalid_index) {
    throw InternalError("a shortest path leads to vertices that no path reaches");
  }
  points.push_back(mesh.vertex_point(best));
  return best;
}

/// Drops points that repeat the one before, and sums the stretches between the rest.
void GeodesicSolver::Data::measure(GeodesicPath& path) const {
  std::vector<SurfacePoint> kept;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (const SurfacePoint& point : path.points) {
    const Eigen::Vector3d here = position_of(point, *topology, positions);
    const double stretch = kept.empty() ? 0.0 : (here - last).norm();
    if (!kept.empty() && stretch <= 1e-12 * mesh.mean_length()) continue;
    path.length += stretch;
    kept.push_back(point);
    last = here;
  }
  path.points = std::move(kept);
}

GeodesicPath GeodesicSolver::path_to(const GeodesicField& field, VertexIndex v) const {
  data_->check_field(field, v, data_->inner.size());
  return data_->trace(field, field.arrivals[v], field.distances[v], vertex_point(topology(), v),
                      true);
}

GeodesicPath GeodesicSolver::path_to_target(const GeodesicField& field, std::size_t target) const {
  data_->check_field(field, target, field.target_distances.size());
  return data_->trace(field, field.arrivals[data_->inner.size() + target],
                      field.target_distances[target], field.targets[target], false);
}

void GeodesicSolver::Data::check_field(const GeodesicField& field, std::size_t index,
                                       std::size_t count) const {
  if (field.method == GeodesicMethod::heat) {
    throw UsageError({.what = "the heat method gives distances, but no paths",
                      .remedy = "Use the exact method for paths"});
  }
  if (index >= count) {
    throw UsageError({.what = "there is no vertex or target " + std::to_string(index) +
                              " (0-based): there are " + std::to_string(count)});
  }
  if (field.arrivals.size() != inner.size() + field.target_distances.size()) {
    throw InternalError("path_to: the field was not made by this solver");
  }
}

}  // namespace kinemesh
