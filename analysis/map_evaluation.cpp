#include "analysis/map_evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "config/error.h"
#include "config/parallel.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/surface_measures.h"

namespace kinemesh {
namespace {

constexpr double unmapped_error = std::numeric_limits<double>::infinity();

double quantile(const std::vector<double>& sorted, double q) {
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

MapErrors summary_of(const std::vector<double>& errors, double cutoff) {
  MapErrors s;
  for (const double e : errors) {
    if (std::isfinite(e)) s.sorted.push_back(e);
  }
  s.unmapped = errors.size() - s.sorted.size();
  if (s.sorted.empty()) {
    throw NoResultError({.what = "the map leaves every place of the truth unmapped"});
  }
  std::ranges::sort(s.sorted);
  s.mean =
      std::accumulate(s.sorted.begin(), s.sorted.end(), 0.0) / static_cast<double>(s.sorted.size());
  s.median = quantile(s.sorted, 0.5);
  s.p75 = quantile(s.sorted, 0.75);
  s.p90 = quantile(s.sorted, 0.9);
  s.p95 = quantile(s.sorted, 0.95);
  s.p99 = quantile(s.sorted, 0.99);
  s.worst = s.sorted.back();
  double area = 0.0;
  for (const double e : s.sorted) area += std::max(0.0, cutoff - e) / cutoff;
  s.area_under_curve = area / static_cast<double>(errors.size());
  return s;
}

/// The distance over the surface between two points: within a radius that grows until it is found,
/// as most errors are small beside the mesh.
double distance_between(const GeodesicSolver& solver, const SurfacePoint& from,
                        const SurfacePoint& to, double chord, double root_area) {
  for (double radius = 1.5 * chord + 0.02 * root_area;; radius *= 3.0) {
    const bool all = radius > 30.0 * root_area;
    const double distance =
        solver.solve({from}, {.radius_mm = all ? 0.0 : radius}, {}, {to}).target_distances[0];
    if (std::isfinite(distance) || all) return distance;
  }
}

/// Every n-th index so that about `samples` are left.
std::vector<std::size_t> chosen(std::size_t count, int samples) {
  const auto most = samples > 0 ? std::min(count, static_cast<std::size_t>(samples)) : count;
  std::vector<std::size_t> indices(most);
  for (std::size_t k = 0; k < most; ++k) indices[k] = k * count / most;
  return indices;
}

void check(const SurfaceMap& map, const MapTruth& truth, const Mesh& target) {
  const std::size_t faces = target.topology->face_count();
  for (const SurfacePoint& p : map.points) {
    if (p.valid() && p.face >= faces) {
      throw InputError({.what = "the map leads to face " + std::to_string(p.face) +
                                ", which the target mesh does not have",
                        .remedy = "Name the mesh that the map leads to with --target"});
    }
  }
  for (const MapTruth::Place& place : truth.places) {
    if (place.source >= map.points.size()) {
      throw InputError({.what = "the truth names vertex " + std::to_string(place.source) +
                                ", but the map has " + std::to_string(map.points.size()) +
                                " points"});
    }
    if (!place.target.valid() || place.target.face >= faces ||
        (place.mirrored.valid() && place.mirrored.face >= faces)) {
      throw InputError({.what = "the truth of vertex " + std::to_string(place.source) +
                                " is no point of the target mesh"});
    }
  }
}

double confidence_ratio(const std::vector<double>& errors, const std::vector<double>& confidence) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    if (std::isfinite(errors[k])) order.push_back(k);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return confidence[k]; });
  const std::size_t tenth = order.size() / 10, half = order.size() / 2;
  if (tenth == 0) return 0.0;
  double least = 0.0, most = 0.0;
  for (std::size_t k = 0; k < tenth; ++k) least += errors[order[k]];
  for (std::size_t k = half; k < order.size(); ++k) most += errors[order[k]];
  least /= static_cast<double>(tenth);
  most /= static_cast<double>(order.size() - half);
  return most > 0.0 ? least / most : 0.0;
}

}  // namespace

void MapEvaluationOptions::declare(ParameterSet& p) {
  p.group("evaluation", "Errors against the truth");
  p.number("samples", samples,
           {.min = 0,
            .max = 1e9,
            .help = "Places of the truth that are measured, evenly spread; 0: all"});
  p.number("cutoff", cutoff,
           {.unit = "√area",
            .min = 0.001,
            .max = 10,
            .help = "Largest error that the curve shows and the area below it counts"});
}

double MapErrors::share_within(double error) const {
  const auto end = std::ranges::upper_bound(sorted, error);
  return static_cast<double>(end - sorted.begin()) / static_cast<double>(sorted.size() + unmapped);
}

MapTruth truth_from_map(const SurfaceMap& truth, const SurfaceMap* mirrored) {
  if (mirrored != nullptr && mirrored->points.size() != truth.points.size()) {
    throw InputError({.what = "the truth and its mirror image are of different meshes: " +
                              std::to_string(truth.points.size()) + " and " +
                              std::to_string(mirrored->points.size()) + " points"});
  }
  MapTruth result;
  result.has_mirrored = mirrored != nullptr;
  for (std::size_t v = 0; v < truth.points.size(); ++v) {
    if (!truth.points[v].valid()) continue;
    result.places.push_back({static_cast<VertexIndex>(v), truth.points[v],
                             mirrored != nullptr ? mirrored->points[v] : SurfacePoint{}});
  }
  return result;
}

MapTruth truth_from_lists(const std::vector<VertexIndex>& source,
                          const std::vector<VertexIndex>& target,
                          const std::vector<VertexIndex>& mirrored, const Topology& topology) {
  if (source.size() != target.size() || (!mirrored.empty() && mirrored.size() != target.size())) {
    throw InputError(
        {.what =
             "the lists of landmarks differ in length: " + std::to_string(source.size()) + " and " +
             std::to_string(mirrored.empty() || source.size() != target.size() ? target.size()
                                                                               : mirrored.size()),
         .remedy = "Line k of each must be the same place"});
  }
  MapTruth result;
  result.has_mirrored = !mirrored.empty();
  for (std::size_t k = 0; k < source.size(); ++k) {
    result.places.push_back(
        {source[k], vertex_point(topology, target[k]),
         mirrored.empty() ? SurfacePoint{} : vertex_point(topology, mirrored[k])});
  }
  return result;
}

MapTruth truth_from_pairs(const std::vector<LandmarkPair>& pairs, const Topology& source) {
  MapTruth result;
  for (const LandmarkPair& pair : pairs) {
    const auto& w = pair.source.weights;
    const auto corner = static_cast<std::size_t>(std::ranges::max_element(w) - w.begin());
    if (w[corner] < 1.0 - 1e-9) {
      throw InputError({.what = "the truth names a place of the source inside a face; a map says "
                                "only where vertices lie",
                        .place = pair.name});
    }
    result.places.push_back({source.faces()[pair.source.face][corner], pair.target, {}});
  }
  return result;
}

MapEvaluation evaluate_map(const SurfaceMap& map, const MapTruth& truth, const Mesh& target,
                           const MapEvaluationOptions& options, const RunContext& ctx) {
  options.validate();
  check(map, truth, target);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : target.positions) positions.push_back(p.cast<double>());
  const std::vector<double> areas = vertex_areas(*target.topology, positions);
  const double root_area = std::sqrt(std::accumulate(areas.begin(), areas.end(), 0.0));
  if (!(root_area > 0.0)) throw NoResultError({.what = "the target mesh has no area"});
  const GeodesicSolver solver(target.topology, positions);
  const std::vector<std::size_t> indices = chosen(truth.places.size(), options.samples);
  std::vector<double> direct(indices.size()), mirrored(indices.size()), either(indices.size());
  const auto error_to = [&](const SurfacePoint& image, const SurfacePoint& place) {
    if (!image.valid() || !place.valid()) return unmapped_error;
    const double chord = (position_of(image, *target.topology, positions) -
                          position_of(place, *target.topology, positions))
                             .norm();
    return distance_between(solver, place, image, chord, root_area) / root_area;
  };
  parallel_for(ctx, indices.size(), 16, [&](std::size_t k) {
    const MapTruth::Place& place = truth.places[indices[k]];
    const SurfacePoint& image = map.points[place.source];
    direct[k] = error_to(image, place.target);
    if (truth.has_mirrored) mirrored[k] = error_to(image, place.mirrored);
    either[k] = std::min(direct[k], mirrored[k]);
  });
  MapEvaluation result{summary_of(direct, options.cutoff), {}, {}, 0.0, root_area};
  if (truth.has_mirrored) {
    result.mirrored = summary_of(mirrored, options.cutoff);
    result.either = summary_of(either, options.cutoff);
  }
  if (!map.confidence.empty()) {
    std::vector<double> confidence;
    for (const std::size_t k : indices)
      confidence.push_back(map.confidence[truth.places[k].source]);
    result.confidence_ratio = confidence_ratio(direct, confidence);
  }
  return result;
}

}  // namespace kinemesh
