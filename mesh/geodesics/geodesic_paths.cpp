// Paths behind a field of distances, and the source each vertex belongs to.
#include <algorithm>
#include <optional>
#include <set>
#include <string>

#include "config/error.h"
#include "mesh/geodesics/dijkstra.h"
#include "mesh/geodesics/path_tracing.h"
#include "mesh/geodesics/solver_data.h"

namespace kinemesh {
namespace {

/// Beside invalid_index, which stands for a source.
constexpr VertexIndex no_vertex = invalid_index - 1;

}  // namespace

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
                                         VertexIndex at) const {
  if (distance == unreachable) {
    throw NoResultError({.what = "no path leads from a source to the end point",
                         .remedy = "The mesh may have several pieces, or the end point lies beyond "
                                   "the radius of the search"});
  }
  GeodesicPath path;
  path.points.push_back(end);
  VertexIndex next = no_vertex;
  std::set<VertexIndex> passed;  // vertices that coincide may name each other
  for (std::size_t stretches = 0; stretches < 2 * inner.size() + 16; ++stretches) {
    const std::size_t begin = path.points.size();
    next = straight_stretch(field, arrival, at, path.points);
    passed.insert(at);
    const bool comes_back = next < no_vertex && passed.contains(mesh.original_vertex(next));
    const double detour =
        comes_back ? unreachable : detour_of(field, path.points, begin, next, distance);
    if (detour > 1e-9 * distance + 1e-12 * mesh.mean_length()) {
      // Rounding misled the straight way, in triangles that have hardly an area.
      next = way_beside(field, at, begin, distance + detour, passed, path.points).value_or(next);
    }
    if (next == no_vertex || next == invalid_index) break;
    at = mesh.original_vertex(next);
    arrival = field.arrivals[at];
    distance = field.distances[at];
  }
  path.source = next == invalid_index ? arrival.origin - static_cast<uint32_t>(inner.size())
                                      : finish_along_edges(field, at, path.points);
  std::reverse(path.points.begin(), path.points.end());
  measure(path);
  return path;
}

/// Follows a straight stretch back. Returns the inner vertex at its end, invalid_index at a source,
/// no_vertex where it leads nowhere. `at`: the original vertex where it starts, invalid_index for a
/// target inside a face.
VertexIndex GeodesicSolver::Data::straight_stretch(const GeodesicField& field,
                                                   const GeodesicArrival& arrival, VertexIndex at,
                                                   std::vector<SurfacePoint>& points) const {
  const auto count = static_cast<uint32_t>(inner.size());
  if (arrival.origin == invalid_index) return no_vertex;
  const bool at_source = arrival.origin >= count;
  const SurfacePoint origin =
      at_source ? field.sources.at(arrival.origin - count) : mesh.vertex_point(arrival.origin);
  const VertexIndex next = at_source ? invalid_index : arrival.origin;
  if (arrival.halfedge == invalid_index) {
    points.push_back(origin);
    return next;
  }
  // A vertex is the apex of the frame it was reached in; a target lies somewhere in its face.
  const geodesics::Frame& frame = mesh.frame(arrival.halfedge);
  const Eigen::Vector2d start = at != invalid_index
                                    ? Eigen::Vector2d(frame.px, frame.py)
                                    : mesh.in_frame(arrival.halfedge, points.back().weights);
  const geodesics::TraceEnd traced =
      geodesics::trace_straight(mesh, start, arrival, origin, next, points);
  return traced.at_origin ? next : pass_vertex(field, traced, points);
}

/// Appends the vertex through which the path goes on: of several, the one with the shortest way.
VertexIndex GeodesicSolver::Data::pass_vertex(const GeodesicField& field,
                                              const geodesics::TraceEnd& traced,
                                              std::vector<SurfacePoint>& points) const {
  const Eigen::Vector3d here = position_of(points.back(), *topology, positions);
  VertexIndex best = no_vertex;
  double least = unreachable;
  for (const VertexIndex v : traced.vertices) {
    if (v == invalid_index) continue;
    const VertexIndex original = mesh.original_vertex(v);
    const double length = field.distances[original] + (positions[original] - here).norm();
    if (!(length < least)) continue;
    best = v;
    least = length;
  }
  if (best != no_vertex) points.push_back(mesh.vertex_point(best));
  return best;
}

/// By how much the stretch that begins before points[begin] and ends at `next`, with the way from
/// there, is longer than the distance.
double GeodesicSolver::Data::detour_of(const GeodesicField& field,
                                       const std::vector<SurfacePoint>& points, std::size_t begin,
                                       VertexIndex next, double distance) const {
  if (next == no_vertex) return unreachable;
  double length = 0.0;
  for (std::size_t k = begin; k < points.size(); ++k) {
    length += (position_of(points[k], *topology, positions) -
               position_of(points[k - 1], *topology, positions))
                  .norm();
  }
  if (next != invalid_index) length += field.distances[mesh.original_vertex(next)];
  return length - distance;
}

/// Of the vertices of the faces around a vertex (or of the face of a point), the one over which the
/// way to a source is shortest.
GeodesicSolver::Data::Neighbour GeodesicSolver::Data::nearest_beside(
    const GeodesicField& field, VertexIndex at, const SurfacePoint& point,
    const std::set<VertexIndex>& passed) const {
  const Eigen::Vector3d here = position_of(point, *topology, positions);
  Neighbour best{invalid_index, unreachable};
  const auto look = [&](FaceIndex f) {
    for (const VertexIndex v : topology->faces()[f]) {
      const double way = field.distances[v] + (positions[v] - here).norm();
      if (way < best.way && !passed.contains(v)) best = {v, way};
    }
  };
  if (at == invalid_index) {
    look(point.face);
  } else {
    for (const FaceIndex f : topology->faces_of(at)) look(f);
  }
  return best;
}

/// Leaves a stretch that is `way` long, with the rest, where the way over a vertex of its faces is
/// shortest, if that is shorter. Returns that vertex (inner).
std::optional<VertexIndex> GeodesicSolver::Data::way_beside(
    const GeodesicField& field, VertexIndex at, std::size_t begin, double way,
    const std::set<VertexIndex>& passed, std::vector<SurfacePoint>& points) const {
  Neighbour best = nearest_beside(field, at, points[begin - 1], passed);
  std::size_t kept = begin;
  double length = 0.0;
  for (std::size_t k = begin; k < points.size(); ++k) {
    length += (position_of(points[k], *topology, positions) -
               position_of(points[k - 1], *topology, positions))
                  .norm();
    const Neighbour other = nearest_beside(field, invalid_index, points[k], passed);
    if (!(length + other.way < best.way)) continue;
    best = {other.vertex, length + other.way};
    kept = k + 1;
  }
  if (!(best.way < way)) return std::nullopt;
  points.resize(kept);
  points.push_back(vertex_point(*topology, best.vertex));
  return inner[best.vertex];
}

/// The last resort: the shortest way along edges from the last point, a vertex or in a face.
/// Returns the source to which it leads.
uint32_t GeodesicSolver::Data::finish_along_edges(const GeodesicField& field, VertexIndex at,
                                                  std::vector<SurfacePoint>& points) const {
  std::vector<SurfacePoint> sources = field.sources;
  for (SurfacePoint& source : sources) source.face = mesh.inner_face(source.face);
  const geodesics::EdgePaths edges = geodesics::dijkstra(mesh, sources, unreachable, {});
  if (at == invalid_index) {
    points.resize(1);
    at = nearest_beside(field, at, points.back(), {}).vertex;
    points.push_back(vertex_point(*topology, at));
  }
  uint32_t origin = edges.arrivals[inner[at]].origin;
  for (; origin < inner.size(); origin = edges.arrivals[origin].origin) {
    points.push_back(mesh.vertex_point(origin));
  }
  const auto source = origin - static_cast<uint32_t>(inner.size());
  points.push_back(field.sources.at(source));
  return source;
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
  return data_->trace(field, field.arrivals[v], field.distances[v], vertex_point(topology(), v), v);
}

GeodesicPath GeodesicSolver::path_to_target(const GeodesicField& field, std::size_t target) const {
  data_->check_field(field, target, field.target_distances.size());
  return data_->trace(field, field.arrivals[data_->inner.size() + target],
                      field.target_distances[target], field.targets[target], invalid_index);
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
