#include "analysis/descriptors.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/anim_mesh_hog.h"
#include "config/error.h"
#include "config/parallel.h"

namespace kinemesh {

void describe_by_curves(FeatureSet& set, const AnimatedMesh& animation,
                        const DeformationResult& deformation);

namespace {

constexpr std::size_t bins = 32, sectors = 8, rings = 4;

/// Angles between the middles of the bins.
const std::array<std::array<double, bins>, bins>& bin_angles() {
  static const auto table = [] {
    std::array<Eigen::Vector3d, bins> directions;
    for (std::size_t b = 0; b < bins; ++b) {
      const std::size_t ring = b / sectors;
      const double theta = (static_cast<double>(ring) + 0.5) * std::numbers::pi / rings;
      const double phi = (static_cast<double>(b % sectors) + 0.5) * 2 * std::numbers::pi / sectors;
      directions[b] = {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                       std::cos(theta)};
    }
    std::array<std::array<double, bins>, bins> angles{};
    for (std::size_t a = 0; a < bins; ++a) {
      for (std::size_t b = 0; b < bins; ++b) {
        angles[a][b] = std::acos(std::clamp(directions[a].dot(directions[b]), -1.0, 1.0));
      }
    }
    return angles;
  }();
  return table;
}

/// The transport problem by successive shortest paths with potentials.
class Transport {
 public:
  /// Both sum to 1.
  Transport(const std::array<double, bins>& supply, const std::array<double, bins>& demand)
      : supply_(supply), demand_(demand) {
    // What lies in the same bin need not move.
    for (std::size_t b = 0; b < bins; ++b) {
      const double same = std::min(supply_[b], demand_[b]);
      supply_[b] -= same;
      demand_[b] -= same;
    }
  }

  double cost() {
    constexpr std::size_t most_rounds = 4096;
    for (std::size_t round = 0; round < most_rounds && send(); ++round) {
    }
    double sum = 0.0;
    for (std::size_t a = 0; a < bins; ++a) {
      for (std::size_t b = 0; b < bins; ++b) sum += flow_[a][b] * bin_angles()[a][b];
    }
    return sum;
  }

 private:
  static constexpr std::size_t nodes = 2 * bins;  // supplies, then demands
  static constexpr double dust = 1e-9;

  /// One shortest path from what is left to what is wanted; false when nothing is left.
  bool send() {
    std::array<double, nodes> distance;
    std::array<std::size_t, nodes> parent{};
    std::array<bool, nodes> done{};
    distance.fill(std::numeric_limits<double>::infinity());
    for (std::size_t a = 0; a < bins; ++a) {
      if (supply_[a] > dust) distance[a] = 0.0;
      parent[a] = nodes;
    }
    while (true) {
      std::size_t node = nodes;
      for (std::size_t i = 0; i < nodes; ++i) {
        if (!done[i] && (node == nodes || distance[i] < distance[node])) node = i;
      }
      if (node == nodes || !std::isfinite(distance[node])) break;
      done[node] = true;
      relax(node, distance, parent, done);
    }
    std::size_t target = nodes;
    for (std::size_t b = 0; b < bins; ++b) {
      const std::size_t node = bins + b;
      if (demand_[b] <= dust || !std::isfinite(distance[node])) continue;
      if (target == nodes ||
          distance[node] + potential_[node] < distance[target] + potential_[target]) {
        target = node;
      }
    }
    if (target == nodes) return false;
    push(target, parent);
    for (std::size_t i = 0; i < nodes; ++i) {
      if (std::isfinite(distance[i])) potential_[i] += distance[i];
    }
    return true;
  }

  void relax(std::size_t node, std::array<double, nodes>& distance,
             std::array<std::size_t, nodes>& parent, const std::array<bool, nodes>& done) const {
    for (std::size_t other = 0; other < bins; ++other) {
      const bool forward = node < bins;
      const std::size_t next = forward ? bins + other : other;
      if (done[next] || (!forward && flow_[other][node - bins] <= dust)) continue;
      const double cost = forward ? bin_angles()[node][other] : -bin_angles()[other][node - bins];
      const double length = std::max(cost + potential_[node] - potential_[next], 0.0);
      if (distance[node] + length < distance[next]) {
        distance[next] = distance[node] + length;
        parent[next] = node;
      }
    }
  }

  void push(std::size_t target, const std::array<std::size_t, nodes>& parent) {
    double amount = demand_[target - bins];
    std::size_t start = target;
    for (std::size_t node = target; parent[node] != nodes; node = parent[node]) {
      start = parent[node];
      if (node < bins) amount = std::min(amount, flow_[node][parent[node] - bins]);
    }
    amount = std::min(amount, supply_[start]);
    for (std::size_t node = target; parent[node] != nodes; node = parent[node]) {
      if (node >= bins) {
        flow_[parent[node]][node - bins] += amount;
      } else {
        flow_[node][parent[node] - bins] -= amount;
      }
    }
    supply_[start] -= amount;
    demand_[target - bins] -= amount;
  }

  std::array<double, bins> supply_, demand_;
  std::array<std::array<double, bins>, bins> flow_{};
  std::array<double, nodes> potential_{};
};

/// One octant scaled to sum 1; false when it is empty.
bool octant_of(std::span<const float> histogram, std::size_t octant,
               std::array<double, bins>& out) {
  double sum = 0.0;
  for (std::size_t b = 0; b < bins; ++b) {
    out[b] = std::max(0.0, static_cast<double>(histogram[octant * bins + b]));
    sum += out[b];
  }
  if (!(sum > 0.0)) return false;
  for (double& value : out) value /= sum;
  return true;
}

}  // namespace

void DescriptorOptions::declare(ParameterSet& p) {
  p.group("descriptors", "Descriptors of features");
  p.flag("curves", curves, "Write displacement and deformation curves");
  p.flag("histogram", histogram, "Write AnimMeshHoG");
  p.number("patch", patch,
           {.min = 0.5, .max = 10.0, .help = "Radius of AnimMeshHoG's volume in σ and τ"});
}

void DescriptorWeights::declare(ParameterSet& p) {
  p.group("descriptor-weights", "Weights of descriptors");
  p.number("displacement-weight", displacement,
           {.min = 0.0, .max = 1e6, .help = "Weight of the displacement curve"});
  p.number("deformation-weight", deformation,
           {.min = 0.0, .max = 1e6, .help = "Weight of the deformation curve"});
  p.number("histogram-weight", histogram,
           {.min = 0.0, .max = 1e6, .help = "Weight of AnimMeshHoG"});
}

void describe_features(FeatureSet& set, const AnimatedMesh& animation,
                       const DeformationResult& deformation, const DescriptorOptions& options,
                       const RunContext& ctx) {
  options.validate();
  for (const Feature& f : set.features) {
    if (f.vertex >= animation.vertex_count() || f.frame >= animation.frame_count()) {
      throw UsageError({.what = "the features are not of this animation"});
    }
  }
  if (options.curves) describe_by_curves(set, animation, deformation);
  if (!options.histogram) return;
  const AnimMeshHog hog(animation, deformation, options.patch);
  parallel_for(ctx, set.features.size(), 1, [&](std::size_t i) {
    Feature& f = set.features[i];
    if (f.kind == FeatureKind::deformation) f.descriptor.histogram = hog.histogram(f);
  });
}

double histogram_distance(std::span<const float> a, std::span<const float> b) {
  if (a.size() != 8 * bins || b.size() != 8 * bins) return 0.0;
  double sum = 0.0;
  std::size_t compared = 0;
  for (std::size_t octant = 0; octant < 8; ++octant) {
    std::array<double, bins> x{}, y{};
    if (!octant_of(a, octant, x) || !octant_of(b, octant, y)) continue;
    sum += Transport(x, y).cost();
    ++compared;
  }
  return compared > 0 ? sum / static_cast<double>(compared) : 0.0;
}

double descriptor_distance(const Feature& a, const Feature& b, const DescriptorWeights& weights) {
  const double moved = curve_distance(a.descriptor.displacement, b.descriptor.displacement);
  if (a.kind == FeatureKind::displacement || b.kind == FeatureKind::displacement) return moved;
  return weights.displacement * moved +
         weights.deformation * curve_distance(a.descriptor.deformation, b.descriptor.deformation) +
         weights.histogram * histogram_distance(a.descriptor.histogram, b.descriptor.histogram);
}

}  // namespace kinemesh
