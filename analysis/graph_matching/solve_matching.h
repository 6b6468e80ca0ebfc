// Graph matching with a certificate: the best matching found and a bound below every other.
//
//   const MatchingResult result = solve_matching(read_dd("pair.dd"));
//   result.labelling[i];  result.energy;  result.bound;  result.certified;
//
// Default: tabu search from greedy and disturbed starts for the matching (Taillard 1991), dual
// ascent on the level-1 reformulation for the bound (Adams & Johnson 1994; Hahn & Grant 1998) with
// assignments and pairs struck out by their reduced costs, and branch and bound on what remains.
// The thesis' method, dual decomposition by projected subgradients (Torresani, Kolmogorov & Rother
// 2013; thesis 5.5.2), is `subgradient`.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/graph_matching/matching_problem.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

enum class MatchingMethod { ascent, subgradient };

struct MatchingOptions {
  MatchingMethod method = MatchingMethod::ascent;
  double time_limit_s = 10.0;
  double gap = 1e-7;           ///< stop when the bound is this close, relative to the energy
  int iterations = 1'000'000;  ///< passes over the dual, or subgradient steps, at most
  int local_size = 3;          ///< left nodes in a local subproblem (subgradient)
  int memory_mb = 1024;        ///< what the bound may use; the matching itself needs little
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// A bound this close, relative to the energy, makes a result certified.
inline constexpr double certified_gap = 1e-3;

struct MatchingResult {
  std::vector<uint32_t> labelling;  ///< right node of each left node, or `unmatched`
  double energy = 0.0;
  double bound = 0.0;  ///< no labelling has a smaller energy
  int64_t iterations = 0;
  int64_t branches = 0;  ///< subproblems of branch and bound
  double seconds = 0.0;
  bool certified = false;  ///< bound within `certified_gap` of the energy without the constant, or
                           ///< within rounding
  bool time_is_up = false;
};

/// Throws InputError for a problem that is not valid, CancelledError when ctx is cancelled. The
/// same seed gives the same result unless the time limit ends the search.
MatchingResult solve_matching(const MatchingProblem& problem, const MatchingOptions& options = {},
                              const RunContext& ctx = {});

}  // namespace kinemesh
