// What the methods of solve_matching share: the matching so far, the clock, and when to stop.
// Internal to analysis/graph_matching.
#pragma once

#include <chrono>

#include "analysis/graph_matching/local_search.h"
#include "analysis/graph_matching/pair_table.h"
#include "analysis/graph_matching/solve_matching.h"

namespace kinemesh::graph_matching {

using Clock = std::chrono::steady_clock;

/// Energies and bounds here are those of the problem, without the constant, times
/// 2^table().exponent().
class SearchState {
 public:
  /// `begin`: since when the time limit counts.
  SearchState(const MatchingProblem& problem, const MatchingOptions& options, const RunContext& ctx,
              Clock::time_point begin);

  const PairTable& table() const { return table_; }
  const MatchingOptions& options() const { return options_; }
  LocalSearch& local() { return local_; }
  double simple_bound() const { return simple_bound_; }

  /// What the sums behind a bound may be wrong by.
  double rounding() const;

  /// The least energy found so far.
  double energy() const { return local_.best_energy(); }
  /// Energies from here on are not worth looking for.
  double cutoff() const;
  bool time_is_up();
  /// The time is up or the steps are used; throws CancelledError when the run is cancelled.
  bool stop();
  void count_iteration() { ++iterations_; }
  int64_t iterations() const { return iterations_; }

  /// Starts local search from assignments, which must be unique on both sides.
  void offer(const std::vector<uint32_t>& assignments);
  /// Local search from varied starts until about this much work is done.
  void improve(uint64_t work);

  double seconds() const;
  bool was_out_of_time() const { return out_of_time_; }

 private:
  const MatchingOptions& options_;
  const RunContext& ctx_;
  Clock::time_point begin_;
  PairTable table_;
  LocalSearch local_;
  std::vector<double> least_;
  double simple_bound_, sum_of_magnitudes_;
  int64_t iterations_ = 0;
  uint64_t starts_ = 0;
  bool out_of_time_ = false;
};

/// Both return a bound below every energy, minus infinity when stopped before there was one.
double bound_by_ascent(SearchState& state, int64_t& branches);
double bound_by_subgradient(SearchState& state);

}  // namespace kinemesh::graph_matching
