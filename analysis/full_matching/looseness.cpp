#include "analysis/full_matching/looseness.h"

#include <array>
#include <cmath>

namespace kinemesh::full_matching {

namespace {

constexpr std::size_t trial_vertices = 1500;
constexpr int trial_sweeps = 60;
constexpr double settled_trial = 1e-5;                      // of the energy
constexpr std::array<double, 2> stiffness{6.0, 1.0 / 6.0};  // times the weight of the distortion
constexpr double least_drift = 1e-3;                        // √area: less is noise of the descent
constexpr int spreading_rounds = 4;

void settle(ComposedMap& map, const Signal& weights, double keep_shape, const RunContext& ctx) {
  map.set_weights(weights, keep_shape);
  const double little = settled_trial * map.energy();
  for (int k = 0; k < trial_sweeps; ++k) {
    ctx.check_cancelled();
    if (map.sweep() < little) break;
  }
}

/// Vertices without a value get the mean of their neighbours' that have one, from those outwards;
/// then everything is evened out a little.
void spread(std::vector<double>& values, std::vector<uint8_t> known, const Topology& topology) {
  bool missing = true;
  while (missing) {
    missing = false;
    bool found = false;
    std::vector<uint8_t> next = known;
    for (VertexIndex v = 0; v < values.size(); ++v) {
      if (known[v] != 0) continue;
      double sum = 0.0;
      int count = 0;
      for (const VertexIndex r : topology.neighbours_of(v)) {
        if (known[r] == 0) continue;
        sum += values[r];
        ++count;
      }
      missing = true;
      if (count == 0) continue;
      values[v] = sum / count;
      next[v] = 1;
      found = true;
    }
    if (!found) break;
    known = std::move(next);
  }
  values = smoothed(std::move(values), topology, spreading_rounds);
}

}  // namespace

std::vector<double> smoothed(std::vector<double> values, const Topology& topology, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> next = values;
    for (VertexIndex v = 0; v < values.size(); ++v) {
      const auto ring = topology.neighbours_of(v);
      for (const VertexIndex r : ring) next[v] += values[r];
      next[v] /= static_cast<double>(ring.size() + 1);
    }
    values = std::move(next);
  }
  return values;
}

std::vector<double> looseness_of(ComposedMap& map, const ClosedSurface& closed,
                                 const Signal& weights, double keep_shape, const RunContext& ctx) {
  map.coarsen(trial_vertices, {}, ctx);
  map.set_detail(1.0);
  settle(map, weights, keep_shape, ctx);
  std::vector<Eigen::Vector3d> places(closed.positions.size(), Eigen::Vector3d::Zero());
  std::vector<uint8_t> known(places.size(), 0);
  for (const VertexIndex v : map.alive()) {
    places[v] = map.position(v);
    known[v] = 1;
  }
  std::vector<double> logarithms(places.size(), 0.0);
  for (const double times : stiffness) {
    settle(map, weights, times * keep_shape, ctx);
    for (const VertexIndex v : map.alive()) {
      logarithms[v] += std::log((map.position(v) - places[v]).norm() + least_drift) /
                       static_cast<double>(stiffness.size());
    }
  }
  spread(logarithms, std::move(known), *closed.topology);
  for (double& value : logarithms) value = std::exp(value);
  return logarithms;
}

}  // namespace kinemesh::full_matching
