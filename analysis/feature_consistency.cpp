#include "analysis/feature_consistency.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "analysis/surface_balls.h"
#include "config/error.h"
#include "mesh/geodesics/geodesics.h"

namespace kinemesh {
namespace {

/// A feature in the space of the target: where it lies, and its time as a part of the duration.
struct Place {
  Eigen::Vector3d at;
  double time;
};

bool augment(std::size_t a, const std::vector<std::vector<std::size_t>>& near,
             std::vector<std::size_t>& owner, std::vector<uint8_t>& seen) {
  for (const std::size_t b : near[a]) {
    if (seen[b] != 0) continue;
    seen[b] = 1;
    if (owner[b] == invalid_index || augment(owner[b], near, owner, seen)) {
      owner[b] = a;
      return true;
    }
  }
  return false;
}

/// The largest number of pairs, one to one, that lie within both tolerances.
std::size_t most_pairs(std::span<const Place> a, std::span<const Place> b, double near,
                       double near_time) {
  std::vector<std::vector<std::size_t>> close(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      if ((a[i].at - b[j].at).norm() <= near && std::abs(a[i].time - b[j].time) <= near_time) {
        close[i].push_back(j);
      }
    }
  }
  std::vector<std::size_t> owner(b.size(), invalid_index);
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::vector<uint8_t> seen(b.size(), 0);
    if (augment(i, close, owner, seen)) ++pairs;
  }
  return pairs;
}

void add_nearest(std::span<const Place> from, std::span<const Place> to, double diagonal,
                 std::vector<double>& errors) {
  for (const Place& p : from) {
    double least = std::numeric_limits<double>::infinity();
    for (const Place& q : to) least = std::min(least, (p.at - q.at).norm());
    errors.push_back(least / diagonal);
  }
}

std::span<const Place> strongest(const std::vector<Place>& places, int count) {
  const auto all = std::span<const Place>(places);
  return count > 0 ? all.first(std::min(all.size(), static_cast<std::size_t>(count))) : all;
}

Consistency compare(const std::vector<Place>& a, const std::vector<Place>& b, double diagonal,
                    const ConsistencyOptions& options, std::vector<double>* errors = nullptr) {
  const double near = options.near * diagonal;
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  const auto fewer_a = strongest(a, options.count), fewer_b = strongest(b, options.count);
  const int slack = options.count > 0 ? std::max(options.slack, options.count) : 0;
  const auto more_a = strongest(a, slack), more_b = strongest(b, slack);
  Consistency c;
  c.strict = share(most_pairs(fewer_a, fewer_b, near, options.near_time),
                   std::max(fewer_a.size(), fewer_b.size()));
  c.slack = 0.5 * (share(most_pairs(fewer_a, more_b, near, options.near_time), fewer_a.size()) +
                   share(most_pairs(fewer_b, more_a, near, options.near_time), fewer_b.size()));
  std::vector<double> nearest;
  add_nearest(fewer_a, fewer_b, diagonal, nearest);
  add_nearest(fewer_b, fewer_a, diagonal, nearest);
  c.nearest =
      share(static_cast<std::size_t>(std::count_if(nearest.begin(), nearest.end(),
                                                   [&](double e) { return e <= options.near; })),
            nearest.size());
  if (errors != nullptr) errors->insert(errors->end(), nearest.begin(), nearest.end());
  return c;
}

void add(Consistency& sum, const Consistency& c, int trials) {
  sum.strict += c.strict / trials;
  sum.slack += c.slack / trials;
  sum.nearest += c.nearest / trials;
}

struct Comparison {
  const FeatureSet& source;
  const FeatureSet& target;
  const SurfaceMap& truth;
  const Mesh& mesh;

  bool mapped(VertexIndex v) const { return truth.points[v].valid(); }
  Place source_place(VertexIndex v, double time) const {
    return {position_of(truth.points[v], *mesh.topology, mesh.positions), time};
  }
  Place target_place(VertexIndex v, double time) const {
    return {mesh.positions[v].cast<double>(), time};
  }
  static double part(const FeatureSet& set, const Feature& f) {
    return (f.frame + 0.5) / static_cast<double>(set.frame_count);
  }
};

void check(const Comparison& c) {
  if (c.truth.points.size() != c.source.vertex_count ||
      c.mesh.positions.size() != c.target.vertex_count) {
    throw InputError(
        {.what = "the features, the map and the target mesh are not of the same meshes: "
                 "the map holds " +
                 std::to_string(c.truth.points.size()) + " vertices, the source " +
                 std::to_string(c.source.vertex_count) + "; the target mesh " +
                 std::to_string(c.mesh.positions.size()) + ", the target features " +
                 std::to_string(c.target.vertex_count)});
  }
  for (std::size_t v = 0; v < c.truth.points.size(); ++v) {
    const SurfacePoint& p = c.truth.points[v];
    if (p.valid() && p.face >= c.mesh.topology->face_count()) {
      throw InputError({.what = "the map names face " + std::to_string(p.face) +
                                ", which the target mesh does not have",
                        .place = "vertex " + std::to_string(v)});
    }
  }
}

std::vector<Eigen::Vector3d> in_double(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
  return positions;
}

}  // namespace

void ConsistencyOptions::declare(ParameterSet& p) {
  p.group("consistency", "Comparison with the truth");
  p.number(
      "near", near,
      {.min = 0.0, .max = 1.0, .help = "Tolerance in space, as a part of the target's diagonal"});
  p.number("near-time", near_time,
           {.min = 0.0, .max = 1.0, .help = "Tolerance in time, as a part of the duration"});
  p.number(
      "count", count,
      {.min = 0, .max = 1e6, .help = "So many of the strongest features are compared; 0: all"});
  p.number("slack", slack,
           {.min = 0,
            .max = 1e6,
            .help = "With slack: partners among so many of the other's strongest"});
  p.number("trials", trials,
           {.min = 1, .max = 10000, .help = "Random draws behind the levels by chance"});
}

ConsistencyResult feature_consistency(const FeatureSet& source, const FeatureSet& target,
                                      const SurfaceMap& truth, const Mesh& target_mesh,
                                      const ConsistencyOptions& options, const RunContext& ctx) {
  options.validate();
  const Comparison c{source, target, truth, target_mesh};
  check(c);
  const auto rest = in_double(target_mesh);
  const double diagonal = bounding_diagonal(*target_mesh.topology, rest);
  ConsistencyResult result;
  std::vector<Place> a, b;
  for (const Feature& f : source.features) {
    if (!c.mapped(f.vertex)) {
      ++result.unmapped;
      continue;
    }
    a.push_back(c.source_place(f.vertex, Comparison::part(source, f)));
  }
  for (const Feature& f : target.features) {
    b.push_back(c.target_place(f.vertex, Comparison::part(target, f)));
  }
  result.source_count = a.size();
  result.target_count = b.size();
  result.features = compare(a, b, diagonal, options, &result.errors);
  std::vector<VertexIndex> mapped;
  for (std::size_t v = 0; v < truth.points.size(); ++v) {
    if (truth.points[v].valid()) mapped.push_back(static_cast<VertexIndex>(v));
  }
  std::mt19937_64 random(ctx.seed() + 1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  for (int trial = 0; trial < options.trials; ++trial) {
    std::vector<Place> ra, rb, sa = a;
    for (std::size_t i = 0; i < a.size() && !mapped.empty(); ++i) {
      ra.push_back(c.source_place(mapped[random() % mapped.size()], uniform()));
    }
    for (std::size_t i = 0; i < b.size(); ++i) {
      rb.push_back(c.target_place(static_cast<VertexIndex>(random() % rest.size()), uniform()));
    }
    for (std::size_t i = sa.size(); i > 1; --i) std::swap(sa[i - 1].time, sa[random() % i].time);
    add(result.random, compare(ra, rb, diagonal, options, &result.random_errors), options.trials);
    add(result.shuffled, compare(sa, b, diagonal, options), options.trials);
  }
  std::sort(result.errors.begin(), result.errors.end());
  std::sort(result.random_errors.begin(), result.random_errors.end());
  return result;
}

std::vector<double> feature_coverage(const FeatureSet& features, const Mesh& mesh) {
  if (features.vertex_count != mesh.positions.size()) {
    throw InputError(
        {.what = "the features are of a mesh with " + std::to_string(features.vertex_count) +
                 " vertices, but this one has " + std::to_string(mesh.positions.size())});
  }
  const GeodesicSolver solver(mesh);
  std::vector<double> count(mesh.positions.size(), 0.0);
  for (const Feature& f : features.features) {
    // Displacement features have no scale, and so no region.
    if (!(f.sigma_mm > 0.0) || f.vertex >= count.size() ||
        mesh.topology->faces_of(f.vertex).empty()) {
      continue;
    }
    for (const auto& [v, distance] :
         solver.within(vertex_point(*mesh.topology, f.vertex), f.sigma_mm)) {
      count[v] += 1.0;
    }
  }
  return count;
}

std::vector<RegionScore> compare_regions(const FeatureSet& features, const Mesh& mesh,
                                         std::span<const double> marked,
                                         std::span<const double> thresholds) {
  if (marked.size() != mesh.positions.size()) {
    throw InputError({.what = "the marked regions have " + std::to_string(marked.size()) +
                              " vertices, but the mesh " + std::to_string(mesh.positions.size())});
  }
  const std::vector<double> covered = feature_coverage(features, mesh);
  const std::vector<double> areas = vertex_areas(*mesh.topology, in_double(mesh));
  std::vector<RegionScore> scores;
  for (const double threshold : thresholds) {
    double both = 0.0, found = 0.0, wanted = 0.0;
    for (std::size_t v = 0; v < areas.size(); ++v) {
      const bool in_truth = marked[v] > threshold, in_features = covered[v] > 0.0;
      both += in_truth && in_features ? areas[v] : 0.0;
      found += in_features ? areas[v] : 0.0;
      wanted += in_truth ? areas[v] : 0.0;
    }
    scores.push_back(
        {threshold, found > 0.0 ? both / found : 0.0, wanted > 0.0 ? both / wanted : 0.0});
  }
  return scores;
}

}  // namespace kinemesh
