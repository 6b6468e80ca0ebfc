#include "reconstruct/surface.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/error.h"
#include "reconstruct/delaunay_flips.h"
#include "reconstruct/surface_cgal.h"
#include "reconstruct/surface_repair.h"

namespace kinemesh {
namespace {

/// A sphere whose boundary loops are all that distinguishes it from a closed surface.
bool has_genus_zero(const EditMesh& mesh) {
  return mesh.euler_characteristic() == 2 - static_cast<int64_t>(mesh.boundary_loops().size());
}

std::size_t count_missing(const EditMesh& mesh) {
  std::size_t missing = 0;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) missing += mesh.has_vertex(v) ? 0 : 1;
  return missing;
}

bool is_sound(const EditMesh& mesh) {
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
    if (!mesh.has_vertex(v) || !mesh.has_one_fan(v)) return false;
  }
  return has_genus_zero(mesh);
}

/// The triangles of a construction, made one manifold component.
EditMesh cleaned(const Points& points, const std::vector<Triangle>& triangles) {
  EditMesh mesh(points.size(), triangles);
  mend_pinches(mesh, points);
  keep_largest_component(mesh, points);
  return mesh;
}

/// Holes, left-out markers, rim and flips: from a cleaned mesh to the result.
bool complete(Surface& s, const Points& points, const SurfaceOptions& options,
              const RunContext& ctx) {
  const double h = s.spacing.mean;
  ctx.check_cancelled();
  s.holes_filled = fill_holes(s.mesh, points, options.hole_bound * h);
  s.outwardness = orient_outwards(s.mesh, points);
  const auto& [edges, no_edges] = options.constraints;
  s.flips = flip_to_delaunay(s.mesh, points, {}, {}, ctx);
  s.inserted = insert_missing_vertices(s.mesh, points);
  s.flips += flip_to_delaunay(s.mesh, points, {}, {}, ctx);
  if (!options.constraints.empty()) {
    apply_constraints(s.mesh, points, options.constraints);
    s.flips += flip_to_delaunay(s.mesh, points, edges, no_edges, ctx);
    s.unmet = apply_constraints(s.mesh, points, options.constraints);
  }
  s.rim_faces_trimmed = trim_rim(s.mesh, points, s.spacing, options.rim_bound, edges);
  s.outwardness = orient_outwards(s.mesh, points);
  return is_sound(s.mesh);
}

bool try_advancing_front(Surface& s, const Points& points, const SurfaceOptions& options,
                         const RunContext& ctx) {
  const double most_missing = std::max(2.0, 0.05 * static_cast<double>(points.size()));
  for (const double widening : {1.0, 1.25, 1.6, 0.85}) {
    s.bound = options.edge_bound * widening;
    std::vector<double> bounds;
    for (const double local : s.spacing.of_vertex)
      bounds.push_back(s.bound * std::max(local, s.spacing.mean));
    s.mesh = cleaned(points, advancing_front(points, bounds));
    if (s.mesh.face_count() == 0 || !has_genus_zero(s.mesh)) continue;
    if (static_cast<double>(count_missing(s.mesh)) > most_missing) continue;
    if (complete(s, points, options, ctx)) return true;
  }
  return false;
}

/// Least-squares sphere: |p|² = 2 p·c + (r² − |c|²).
Eigen::Vector3d sphere_centre(const Points& points) {
  Eigen::MatrixX4d a(points.size(), 4);
  Eigen::VectorXd b(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    a.row(row) << 2 * points[i].transpose(), 1;
    b[row] = points[i].squaredNorm();
  }
  return a.colPivHouseholderQr().solve(b).head<3>();
}

/// Points on an azimuthal equidistant map of the sphere around them, centred on their mean.
std::vector<Eigen::Vector2d> sphere_chart(const Points& points, double h) {
  const Eigen::Vector3d centre = sphere_centre(points);
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (const auto& p : points) axis += (p - centre).normalized();
  axis.normalize();
  Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  std::vector<Eigen::Vector2d> chart;
  for (const auto& p : points) {
    const Eigen::Vector3d d = (p - centre).normalized();
    const Eigen::Vector2d across(d.dot(u), d.dot(v));
    const double angle = std::atan2(across.norm(), d.dot(axis));
    chart.emplace_back(across.norm() > 0 ? Eigen::Vector2d(angle / across.norm() * across / h)
                                         : across);
  }
  return chart;
}

using PrincipalSpreads = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>;

PrincipalSpreads principal_spreads(const Points& points, const Eigen::Vector3d& mean) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& p : points) covariance += (p - mean) * (p - mean).transpose();
  return PrincipalSpreads(covariance);
}

Eigen::Vector3d mean_of(const Points& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  return mean;
}

std::vector<Eigen::Vector2d> plane_chart(const Points& points) {
  const Eigen::Vector3d mean = mean_of(points);
  const auto solver = principal_spreads(points, mean);
  std::vector<Eigen::Vector2d> chart;
  for (const auto& p : points) {
    chart.emplace_back((p - mean).dot(solver.eigenvectors().col(2)),
                       (p - mean).dot(solver.eigenvectors().col(1)));
  }
  return chart;
}

/// The cloud has an extent in two directions at least.
bool spans_a_surface(const Points& points) {
  constexpr double least = 1e-3;  // spread across over spread along
  const Eigen::Vector3d spread = principal_spreads(points, mean_of(points)).eigenvalues();
  return spread[1] > least * least * spread[2];
}

bool try_chart(Surface& s, const Points& points, const SurfaceOptions& options,
               const std::vector<Eigen::Vector2d>& chart, const RunContext& ctx) {
  s.bound = 0.0;
  for (const auto& p : chart) {
    if (!p.allFinite()) return false;
  }
  s.mesh = cleaned(points, planar_delaunay(chart));
  return s.mesh.face_count() > 0 && complete(s, points, options, ctx);
}

}  // namespace

Surface reconstruct_surface(const Points& points, const SurfaceOptions& options,
                            const RunContext& ctx) {
  const ErrorDetails none{
      .what = "no surface goes through the markers: they lie on a line or at one place",
      .remedy = "Choose the markers with --markers, or another frame with --frame"};
  if (!spans_a_surface(points)) throw NoResultError(none);
  Surface s;
  s.spacing = measure_spacing(points);
  s.method = "advancing front";
  if (try_advancing_front(s, points, options, ctx)) return s;
  s.method = "sphere chart";
  if (points.size() > 4 && try_chart(s, points, options, sphere_chart(points, s.spacing.mean), ctx))
    return s;
  s.method = "plane chart";
  if (try_chart(s, points, options, plane_chart(points), ctx)) return s;
  throw NoResultError(none);
}

}  // namespace kinemesh
