// Matching problems of several kinds, generated from a seed, and their optimum by exhaustive
// search where they are small.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/graph_matching/matching_problem.h"

namespace kinemesh::test {

enum class InstanceKind {
  geometric,   ///< points and their noisy copies with outliers, rewards for like distances
  distortion,  ///< the same with costs that grow with the distortion
  sparse,      ///< few assignments, pairs among neighbours only
  random,      ///< pair costs without any structure
  complete     ///< Koopmans–Beckmann with a gain that makes every node be matched
};

inline MatchingProblem make_instance(InstanceKind kind, uint32_t nodes, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.02);
  const auto point = [&] { return std::pair(unit(random), unit(random)); };
  std::vector<std::pair<double, double>> left, right;
  for (uint32_t i = 0; i < nodes; ++i) left.push_back(point());
  for (uint32_t i = 0; i < nodes; ++i) {
    right.push_back(4 * i < 3 * nodes
                        ? std::pair(left[i].first + noise(random), left[i].second + noise(random))
                        : point());
  }
  const auto distance = [](const auto& points, uint32_t i, uint32_t k) {
    return std::hypot(points[i].first - points[k].first, points[i].second - points[k].second);
  };
  MatchingProblem p{.left_count = nodes, .right_count = nodes};
  for (uint32_t i = 0; i < nodes; ++i) {
    for (uint32_t j = 0; j < nodes; ++j) {
      if (kind == InstanceKind::sparse && i != j && unit(random) > 0.3) continue;
      const double base = kind == InstanceKind::complete ? -1000.0 : 0.2 * unit(random) - 0.1;
      p.assignments.push_back({i, j, base});
    }
  }
  for (uint32_t a = 0; a < p.assignments.size(); ++a) {
    for (uint32_t b = a + 1; b < p.assignments.size(); ++b) {
      const MatchingAssignment &x = p.assignments[a], &y = p.assignments[b];
      if (x.left == y.left || x.right == y.right) continue;
      const double d = distance(left, x.left, y.left), e = distance(right, x.right, y.right);
      if (kind == InstanceKind::sparse && d > 0.4) continue;
      double cost = -std::exp(-std::pow((d - e) / 0.05, 2));
      if (kind == InstanceKind::distortion) cost = 5.0 * std::abs(d - e) - 0.15;
      if (kind == InstanceKind::random) cost = 2.0 * unit(random) - 1.0;
      if (kind == InstanceKind::complete) cost = std::round(10.0 * d) * std::round(10.0 * e);
      if (std::abs(cost) > 1e-4) p.pairs.push_back({a, b, cost});
    }
  }
  return p;
}

/// The least energy over all labellings; for up to six left nodes.
inline double exhaustive_optimum(const MatchingProblem& p) {
  std::vector<uint32_t> labelling(p.left_count, unmatched);
  double best = p.energy(labelling);
  const auto search = [&](const auto& self, uint32_t i) -> void {
    if (i == p.left_count) {
      best = std::min(best, p.energy(labelling));
      return;
    }
    labelling[i] = unmatched;
    self(self, i + 1);
    for (const MatchingAssignment& a : p.assignments) {
      if (a.left != i || std::ranges::count(labelling, a.right) > 0) continue;
      labelling[i] = a.right;
      self(self, i + 1);
      labelling[i] = unmatched;
    }
  };
  search(search, 0);
  return best;
}

}  // namespace kinemesh::test
