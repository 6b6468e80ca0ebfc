#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "analysis/deformation.h"
#include "analysis/feature_matching.h"
#include "config/error.h"
#include "config/parallel.h"
#include "mesh/geodesics/geodesics.h"

namespace kinemesh {
namespace {

constexpr double normal_radius = 0.06;       // of √area: over which normals are averaged
constexpr std::size_t average_sources = 48;  // for the average-geodesic distance

void check(const FeatureSet& set, const AnimatedMesh& animation) {
  if (animation.frame_count() == 0 || animation.topology().face_count() == 0) {
    throw NoResultError({.what = "the animation has no frames or no faces to measure on"});
  }
  for (std::size_t k = 0; k < set.features.size(); ++k) {
    const Feature& f = set.features[k];
    if (f.vertex < animation.vertex_count() && f.frame < animation.frame_count()) continue;
    throw InputError({.what = "feature " + std::to_string(k) + " lies at vertex " +
                              std::to_string(f.vertex) + " and frame " + std::to_string(f.frame) +
                              ", which the animation does not have",
                      .file = set.animation,
                      .remedy = "Give the animation in which the features were found"});
  }
}

/// Twice the area-weighted normal of each face, added to its corners.
std::vector<Eigen::Vector3d> vertex_normals(const Mesh& mesh, double& area) {
  std::vector<Eigen::Vector3d> normals(mesh.positions.size(), Eigen::Vector3d::Zero());
  area = 0.0;
  for (const Triangle& face : mesh.topology->faces()) {
    const Eigen::Vector3d a = mesh.positions[face[0]].cast<double>();
    const Eigen::Vector3d normal = (mesh.positions[face[1]].cast<double>() - a)
                                       .cross(mesh.positions[face[2]].cast<double>() - a);
    area += 0.5 * normal.norm();
    for (const VertexIndex v : face) normals[v] += normal;
  }
  return normals;
}

/// Length of each step of the vertex; frames − 1 values.
std::vector<float> steps_of(const AnimatedMesh& animation, VertexIndex v) {
  std::vector<float> steps;
  for (std::size_t f = 1; f < animation.frame_count(); ++f) {
    steps.push_back((animation.position(f, v) - animation.position(f - 1, v)).norm());
  }
  return steps;
}

float largest_step(const AnimatedMesh& animation) {
  float largest = 0.0F;
  for (std::size_t f = 1; f < animation.frame_count(); ++f) {
    largest = std::max(largest,
                       (animation.frame(f) - animation.frame(f - 1)).rowwise().norm().maxCoeff());
  }
  return largest;
}

void scale(std::vector<float>& values, float by) {
  if (by > 0.0F) {
    for (float& value : values) value /= by;
  }
}

void fill_curves(FeaturePlaces& result, const AnimatedMesh& animation, const RunContext& ctx) {
  using Place = FeaturePlaces::Place;
  if (std::ranges::any_of(result.places, [](const Place& p) { return p.displacement.empty(); })) {
    const float largest = largest_step(animation);
    for (Place& p : result.places) {
      if (!p.displacement.empty()) continue;
      p.displacement = steps_of(animation, p.feature.vertex);
      scale(p.displacement, largest);
    }
  }
  if (std::ranges::any_of(result.places, [](const Place& p) { return p.deformation.empty(); })) {
    const DeformationResult deformation = deformation_of(animation, {}, ctx);
    for (Place& p : result.places) {
      if (!p.deformation.empty()) continue;
      const std::span<const float> curve = deformation.values.of(p.feature.vertex);
      p.deformation.assign(curve.begin(), curve.end());
      scale(p.deformation, deformation.largest);
    }
  }
}

/// The class of a curve: it may fall back, or rise again, by `tolerance` of its range.
PathClass class_of(const std::vector<double>& curve, double scale, double tolerance) {
  const auto [low, high] = std::ranges::minmax(curve);
  const double range = high - low;
  if (range < 0.01 * scale) return PathClass::level;
  double highest = curve.front(), lowest = curve.front(), fall = 0.0, rise = 0.0;
  for (const double value : curve) {
    highest = std::max(highest, value);
    lowest = std::min(lowest, value);
    fall = std::max(fall, highest - value);
    rise = std::max(rise, value - lowest);
  }
  if (fall <= tolerance * range) return PathClass::increasing;
  if (rise <= tolerance * range) return PathClass::decreasing;
  return PathClass::neither;
}

/// The mean distance of every vertex to vertices spread over the mesh.
std::vector<double> average_distances(const GeodesicSolver& solver, const Mesh& mesh,
                                      const RunContext& ctx) {
  const std::size_t count = mesh.positions.size();
  std::vector<double> sum(count, 0.0), row(count);
  std::vector<char> has_face(count, 0);
  for (const Triangle& face : mesh.topology->faces()) {
    for (const VertexIndex v : face) has_face[v] = 1;
  }
  double used = 0.0;
  const std::size_t stride = std::max<std::size_t>(1, count / average_sources);
  for (std::size_t v = 0; v < count; v += stride) {
    ctx.check_cancelled();
    if (has_face[v] == 0) continue;
    solver.exact_distances(vertex_point(solver.topology(), static_cast<VertexIndex>(v)), row);
    used += 1.0;
    for (std::size_t w = 0; w < count; ++w) sum[w] += std::isfinite(row[w]) ? row[w] : 0.0;
  }
  for (double& value : sum) value /= std::max(used, 1.0);
  return sum;
}

void classify_paths(FeaturePlaces& result, const GeodesicSolver& solver, const Mesh& mesh,
                    double tolerance, const RunContext& ctx) {
  const std::vector<double> average = average_distances(solver, mesh, ctx);
  const std::size_t count = result.places.size();
  result.path_classes.assign(count * count, PathClass::level);
  parallel_for(ctx, count, 1, [&](std::size_t p) {
    const GeodesicField field =
        solver.solve(result.places[p].feature.vertex, {.method = GeodesicMethod::dijkstra}, ctx);
    for (std::size_t q = 0; q < count; ++q) {
      const VertexIndex end = result.places[q].feature.vertex;
      if (q == p || !std::isfinite(field.distances[end])) continue;
      std::vector<double> curve;
      for (const SurfacePoint& point : solver.path_to(field, end).points) {
        double value = 0.0;
        for (int c = 0; c < 3; ++c) {
          value += point.weights[c] * average[solver.topology().faces()[point.face][c]];
        }
        curve.push_back(value);
      }
      result.path_classes[p * count + q] = class_of(curve, result.root_area_mm, tolerance);
    }
  });
}

void measure_distances(FeaturePlaces& result, const GeodesicSolver& solver,
                       const std::vector<Eigen::Vector3d>& normals, const RunContext& ctx) {
  const std::size_t count = result.places.size();
  const auto size = static_cast<Eigen::Index>(count);
  result.distances.resize(size, size);
  parallel_for(ctx, count, 1, [&](std::size_t p) {
    std::vector<double> row(normals.size());
    FeaturePlaces::Place& place = result.places[p];
    solver.exact_distances(vertex_point(solver.topology(), place.feature.vertex), row);
    for (std::size_t q = 0; q < count; ++q) {
      result.distances(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(q)) =
          row[result.places[q].feature.vertex] / result.root_area_mm;
    }
    place.normal.setZero();
    for (std::size_t v = 0; v < row.size(); ++v) {
      if (row[v] <= normal_radius * result.root_area_mm) place.normal += normals[v];
    }
    place.normal.normalize();
  });
}

}  // namespace

FeaturePlaces feature_places(const FeatureSet& set, const AnimatedMesh& animation,
                             const FeatureMatchingOptions& options, const RunContext& ctx) {
  options.validate();
  check(set, animation);
  const Mesh rest = animation.mesh_at(0);
  double area = 0.0;
  const std::vector<Eigen::Vector3d> normals = vertex_normals(rest, area);
  if (area <= 0.0) throw NoResultError({.what = "the mesh has no area", .file = set.animation});
  FeaturePlaces result;
  result.root_area_mm = std::sqrt(area);
  const double last = std::max<double>(1.0, static_cast<double>(animation.frame_count()) - 1.0);
  for (std::size_t k = 0; k < set.features.size(); ++k) {
    const Feature& f = set.features[k];
    result.places.push_back({.feature = f,
                             .index = static_cast<uint32_t>(k),
                             .position = rest.positions[f.vertex].cast<double>(),
                             .normal = Eigen::Vector3d::Zero(),
                             .time = static_cast<double>(f.frame) / last,
                             .displacement = f.descriptor.displacement,
                             .deformation = f.descriptor.deformation});
  }
  if (result.places.empty()) return result;
  fill_curves(result, animation, ctx);
  const GeodesicSolver solver(rest);
  measure_distances(result, solver, normals, ctx);
  if (options.prior != GeodesicPrior::none) {
    classify_paths(result, solver, rest, options.prior_tolerance, ctx);
  }
  return result;
}

}  // namespace kinemesh
