#include "mesh/geodesics/geodesics.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "config/error.h"
#include "mesh/geodesics/dijkstra.h"
#include "mesh/geodesics/solver_data.h"

namespace kinemesh {

using geodesics::UnfoldedMesh;

namespace {

std::vector<Eigen::Vector3d> to_double(std::span<const Eigen::Vector3f> positions) {
  std::vector<Eigen::Vector3d> result(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) result[i] = positions[i].cast<double>();
  return result;
}

double search_radius(double radius_mm) { return radius_mm > 0.0 ? radius_mm : unreachable; }

/// Checks a point of the original mesh, snaps its weights to sum 1, and renumbers its face.
SurfacePoint inner_point(const UnfoldedMesh& mesh, const SurfacePoint& point) {
  const double sum = point.weights[0] + point.weights[1] + point.weights[2];
  const double least = *std::min_element(point.weights.begin(), point.weights.end());
  if (point.face >= mesh.face_count() || !(std::abs(sum - 1.0) < 1e-6) || !(least > -1e-6)) {
    throw UsageError(
        {.what = "a point for a geodesic search does not lie on the mesh (face " +
                 (point.valid() ? std::to_string(point.face) : "none") + ")",
         .remedy = "Name a face of the mesh and three weights of at least 0 with sum 1"});
  }
  SurfacePoint result;
  result.face = mesh.inner_face(point.face);
  double clamped_sum = 0.0;
  for (int c = 0; c < 3; ++c) clamped_sum += result.weights[c] = std::max(point.weights[c], 0.0);
  for (double& weight : result.weights) weight /= clamped_sum;
  return result;
}

std::vector<SurfacePoint> inner_points(const UnfoldedMesh& mesh,
                                       const std::vector<SurfacePoint>& points) {
  std::vector<SurfacePoint> result;
  result.reserve(points.size());
  for (const SurfacePoint& point : points) result.push_back(inner_point(mesh, point));
  return result;
}

}  // namespace

void GeodesicOptions::declare(ParameterSet& p) {
  p.group("geodesics", "Distances over the surface");
  p.choice<GeodesicMethod>(
      "method", method,
      {{GeodesicMethod::exact, "exact", "exact distances on the triangles"},
       {GeodesicMethod::dijkstra, "dijkstra", "along edges: some 5 to 10 % too long"},
       {GeodesicMethod::heat, "heat",
        "by diffusion: quick for many sources, on average 1 to 2 % off"}},
      "How distances are measured");
  p.number("radius", radius_mm,
           {.unit = "mm",
            .min = 0.0,
            .max = 1e9,
            .help = "Leave out what is further away than this; 0 measures everything"});
  p.number("heat-time", heat_time,
           {.min = 0.01,
            .max = 1e4,
            .help = "Diffusion time of the heat method in squared mean edge lengths; larger is "
                    "smoother"});
}

SurfacePoint vertex_point(const Topology& topology, VertexIndex v) {
  if (v >= topology.vertex_count() || topology.faces_of(v).empty()) {
    throw UsageError(
        {.what = "vertex " + std::to_string(v) + " (0-based) " +
                 (v >= topology.vertex_count()
                      ? "does not exist: the mesh has " + std::to_string(topology.vertex_count())
                      : "belongs to no face")});
  }
  SurfacePoint point;
  point.face = topology.faces_of(v)[0];
  const Triangle& face = topology.faces()[point.face];
  point.weights[std::find(face.begin(), face.end(), v) - face.begin()] = 1.0;
  return point;
}

std::vector<SurfacePoint> vertex_points(const Topology& topology,
                                        std::span<const VertexIndex> vertices) {
  std::vector<SurfacePoint> points;
  for (const VertexIndex v : vertices) points.push_back(vertex_point(topology, v));
  return points;
}

GeodesicSolver::GeodesicSolver(std::shared_ptr<const Topology> topology,
                               std::span<const Eigen::Vector3d> positions)
    : data_(std::make_unique<Data>(std::move(topology), positions)) {}
GeodesicSolver::GeodesicSolver(std::shared_ptr<const Topology> topology,
                               std::span<const Eigen::Vector3f> positions)
    : GeodesicSolver(std::move(topology), to_double(positions)) {}
GeodesicSolver::GeodesicSolver(const Mesh& mesh) : GeodesicSolver(mesh.topology, mesh.positions) {}
GeodesicSolver::GeodesicSolver(GeodesicSolver&&) noexcept = default;
GeodesicSolver& GeodesicSolver::operator=(GeodesicSolver&&) noexcept = default;
GeodesicSolver::~GeodesicSolver() = default;

const Topology& GeodesicSolver::topology() const { return *data_->topology; }

GeodesicField GeodesicSolver::solve(const std::vector<SurfacePoint>& sources,
                                    const GeodesicOptions& options, const RunContext& ctx,
                                    const std::vector<SurfacePoint>& targets) const {
  options.validate();
  if (sources.empty()) {
    throw UsageError({.what = "a geodesic search needs at least one source"});
  }
  GeodesicField field;
  field.method = options.method;
  field.sources = sources;
  field.targets = targets;
  field.diagnostics.degenerate_faces = data_->mesh.degenerate_faces();
  const double radius = search_radius(options.radius_mm);
  switch (options.method) {
    case GeodesicMethod::exact: data_->solve_exact(field, radius, ctx); break;
    case GeodesicMethod::dijkstra: data_->solve_dijkstra(field, radius, ctx); break;
    case GeodesicMethod::heat: data_->solve_heat(field, options, ctx); break;
  }
  for (std::vector<double>* distances : {&field.distances, &field.target_distances}) {
    for (double& d : *distances) d = d <= radius ? d : unreachable;
  }
  if (options.method != GeodesicMethod::heat) data_->name_nearest_sources(field);
  return field;
}

GeodesicField GeodesicSolver::solve(VertexIndex source, const GeodesicOptions& options,
                                    const RunContext& ctx) const {
  return solve({vertex_point(topology(), source)}, options, ctx);
}

void GeodesicSolver::Data::solve_exact(GeodesicField& field, double radius, const RunContext& ctx) {
  Loan propagation(*this);
  propagation->run(inner_points(mesh, field.sources), inner_points(mesh, field.targets), radius,
                   &ctx);
  for (const VertexIndex v : inner) {
    field.distances.push_back(propagation->distance(v));
    field.arrivals.push_back(propagation->arrival(v));
  }
  for (std::size_t t = 0; t < field.targets.size(); ++t) {
    field.target_distances.push_back(propagation->target_distance(t));
    field.arrivals.push_back(propagation->target_arrival(t));
  }
  // A source vertex is where paths end; say which source it is.
  for (uint32_t s = 0; s < field.sources.size(); ++s) {
    const VertexIndex v = propagation->source_vertex(s);
    if (v == invalid_index) continue;
    const Triangle& face = topology->faces()[field.sources[s].face];
    for (const VertexIndex corner : face) {
      if (inner[corner] == v) {
        field.arrivals[corner] = {0.0, 0.0, invalid_index, static_cast<uint32_t>(inner.size() + s)};
      }
    }
  }
  field.diagnostics.windows = propagation->windows();
  field.diagnostics.peak_windows = propagation->peak_windows();
  field.diagnostics.window_bytes = sizeof(geodesics::Window);
}

void GeodesicSolver::Data::solve_dijkstra(GeodesicField& field, double radius,
                                          const RunContext& ctx) {
  const std::vector<SurfacePoint> targets = inner_points(mesh, field.targets);
  const geodesics::EdgePaths paths =
      geodesics::dijkstra(mesh, inner_points(mesh, field.sources), radius, ctx);
  for (const VertexIndex v : inner) {
    field.distances.push_back(paths.distances[v]);
    field.arrivals.push_back(paths.arrivals[v]);
  }
  for (const SurfacePoint& target : targets) {
    double best = unreachable;
    GeodesicArrival arrival;
    for (HalfedgeIndex h = 3 * target.face; h < 3 * target.face + 3; ++h) {
      const VertexIndex v = mesh.frame(h).ends[0];
      const double distance = paths.distances[v] + mesh.in_frame(h, target.weights).norm();
      if (!(distance < best)) continue;
      best = distance;
      arrival.origin = v;
    }
    field.target_distances.push_back(best);
    field.arrivals.push_back(arrival);
  }
}

void GeodesicSolver::Data::solve_heat(GeodesicField& field, const GeodesicOptions& options,
                                      const RunContext& ctx) {
  std::shared_ptr<const HeatMethod> method;
  {
    const std::lock_guard lock(mutex);
    if (!heat || heat_time != options.heat_time) {
      heat = std::make_shared<const HeatMethod>(*topology, positions, options.heat_time);
      heat_time = options.heat_time;
    }
    method = heat;
  }
  ctx.check_cancelled();
  inner_points(mesh, field.sources);  // refuses points that are not on the mesh
  field.distances = method->distances(field.sources);
  for (const SurfacePoint& target : field.targets) {
    inner_point(mesh, target);
    const Triangle& face = topology->faces()[target.face];
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) sum += target.weights[c] * field.distances[face[c]];
    field.target_distances.push_back(std::isnan(sum) ? unreachable : sum);
  }
}

template <class Scalar>
void GeodesicSolver::Data::quick_exact(const SurfacePoint& source, std::span<Scalar> distances,
                                       double radius_mm) {
  if (distances.size() != inner.size()) {
    throw InternalError("exact_distances: the row must hold one distance per vertex");
  }
  const double radius = search_radius(radius_mm);
  const SurfacePoint inner_source = inner_point(mesh, source);
  Loan propagation(*this);
  propagation->run({&inner_source, 1}, {}, radius);
  for (std::size_t v = 0; v < inner.size(); ++v) {
    const double d = propagation->distance(inner[v]);
    distances[v] = static_cast<Scalar>(d <= radius ? d : unreachable);
  }
}

void GeodesicSolver::exact_distances(const SurfacePoint& source, std::span<double> distances,
                                     double radius_mm) const {
  data_->quick_exact(source, distances, radius_mm);
}

void GeodesicSolver::exact_distances(const SurfacePoint& source, std::span<float> distances,
                                     double radius_mm) const {
  data_->quick_exact(source, distances, radius_mm);
}

std::vector<std::pair<VertexIndex, double>> GeodesicSolver::within(const SurfacePoint& source,
                                                                   double radius_mm) const {
  if (!(radius_mm > 0.0)) {
    throw UsageError({.what = "a search within a radius needs a radius above 0 mm"});
  }
  const SurfacePoint inner_source = inner_point(data_->mesh, source);
  std::vector<std::pair<VertexIndex, double>> result;
  Data::Loan propagation(*data_);
  propagation->run({&inner_source, 1}, {}, radius_mm);
  for (const VertexIndex v : propagation->reached()) {
    const double d = propagation->distance(v);
    if (d <= radius_mm) result.emplace_back(data_->mesh.original_vertex(v), d);
  }
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second < b.second : a.first < b.first;
  });
  return result;
}

GeodesicField geodesic_distances(const Mesh& mesh, const std::vector<SurfacePoint>& sources,
                                 const GeodesicOptions& options, const RunContext& ctx) {
  return GeodesicSolver(mesh).solve(sources, options, ctx);
}

GeodesicPath shortest_path(const Mesh& mesh, const SurfacePoint& from, const SurfacePoint& to) {
  const GeodesicSolver solver(mesh);
  return solver.path_to_target(solver.solve({from}, {}, {}, {to}), 0);
}

}  // namespace kinemesh
