// Larger matching problems in the manner of the public benchmarks (Swoboda et al. 2022), generated
// from a seed, with the matching that was planted.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/graph_matching/matching_problem.h"

namespace kinemesh::test {

/// All are views of one cloud of points with noise, some of them without a partner.
enum class ProblemKind {
  house,     ///< two views of a turned object, every assignment, every pair; costs of both signs
  synth,     ///< in the plane, every assignment, every pair, rewards for like distances alone
  car,       ///< every assignment, pairs of neighbours in either image; gains alone
  complete,  ///< every pair; a gain that makes every node be matched, weak unaries
  flow,      ///< few assignments to a node, pairs of neighbours
  worms      ///< few assignments, strong unaries of both signs, pairs of near nodes alone
};

struct PlantedProblem {
  MatchingProblem problem;
  std::vector<uint32_t> planted;  ///< the true right node of each left node, or
                                  ///< `unmatched` where there is none among the assignments
};

struct PlantedOptions {
  uint32_t nodes = 30;     ///< on each side
  double noise = 0.03;     ///< of a point, as a part of the cloud's extent
  double outliers = 0.15;  ///< part of the nodes that have no partner
};

PlantedProblem plant_problem(ProblemKind kind, uint64_t seed, const PlantedOptions& options = {});

}  // namespace kinemesh::test
