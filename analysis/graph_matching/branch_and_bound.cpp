// The ascent method: sweeps of the star relaxation, local search between them, and branch and
// bound once the sweeps no longer pay.
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/graph_matching/search_state.h"
#include "analysis/graph_matching/star_relaxation.h"

namespace kinemesh::graph_matching {
namespace {

constexpr std::size_t entry_bytes = 16;
constexpr int few_stale = 8;                   // then local search gets less of the time
constexpr std::size_t many_entries = 500'000;  // sweeps are slow: a bound before the first

class BranchAndBound {
 public:
  BranchAndBound(SearchState& state, int64_t& branches) : state_(state), branches_(branches) {}

  double run() {
    const std::size_t size = state_.table().size();
    state_.improve(800'000 + 2000 * size);
    if (state_.simple_bound() >= state_.cutoff()) return state_.simple_bound();
    if (state_.stop() || size == 0) return size == 0 ? 0.0 : -infinite;
    StarRelaxation root(
        state_.table(),
        static_cast<std::size_t>(state_.options().memory_mb) * 500'000 / entry_bytes, stop_);
    if (!root.usable()) {
      while (!state_.stop() && state_.simple_bound() < state_.cutoff()) {
        state_.improve(10'000'000);
      }
      return -infinite;
    }
    if (root.entries() > many_entries && !root.lower_rows(stop_)) return -infinite;
    return solve(root, 0);
  }

 private:
  /// Sweeps while they pay. Returns whether the subproblem is settled.
  bool sweep(StarRelaxation& node, int depth) {
    double gained = infinite, energy = state_.energy();
    int stale = 0;  // passes since a better matching was found
    for (int pass = 0;; ++pass) {
      const double before = node.bound();
      if (!node.sweep(state_.cutoff(), stop_)) return false;
      state_.count_iteration();
      if (node.bound() >= state_.cutoff()) return true;
      state_.offer(node.master());
      state_.improve(node.entries() * (depth == 0 && stale < few_stale ? 4 : 1));
      stale = state_.energy() < energy ? 0 : stale + 1;
      energy = state_.energy();
      if (node.bound() >= state_.cutoff()) return true;
      if (node.many_struck_out()) shrink(node);
      // A few passes' mean gain against what is left to gain.
      const double gain = node.bound() - before;
      gained = pass < 2 ? gain : 0.7 * gained + 0.3 * gain;
      const double left = state_.cutoff() - node.bound();
      if (pass >= 3 && gained * 3.0 * node.width() < left && node.can_widen()) {
        shrink(node);
        if (!node.widen(stop_)) return false;
        pass = -1;
        continue;
      }
      const double patience = depth == 0 ? 60.0 : 6.0;
      if (pass >= (depth == 0 ? 10 : 1) && gained * patience < left && may_branch(node)) break;
      if (state_.stop()) return false;
    }
    return false;
  }

  void shrink(StarRelaxation& node) const {
    StarRelaxation smaller = node.chosen(StarRelaxation::none, stop_);
    if (smaller.usable()) node = std::move(smaller);
  }

  bool may_branch(const StarRelaxation& node) const {
    return node.entries() * entry_bytes * 8 <=
           static_cast<std::size_t>(state_.options().memory_mb) * 1'000'000;
  }

  /// A bound on every energy of the subproblem.
  double solve(StarRelaxation& node, int depth) {
    const double before = node.bound();
    if (sweep(node, depth)) return node.bound();
    if (state_.stop()) return std::max(before, node.bound());
    const std::vector<uint32_t> children = node.branch_elements();
    if (children.empty()) return settled(node);
    double bound = infinite;
    for (const uint32_t element : children) {
      const double at_least = node.bound_with(element);
      if (at_least >= state_.cutoff() || state_.stop()) {
        bound = std::min(bound, at_least);
        continue;
      }
      ++branches_;
      StarRelaxation child = node.chosen(element, stop_);
      bound =
          std::min(bound, child.usable() ? std::max(at_least, solve(child, depth + 1)) : at_least);
    }
    return std::max(bound, node.bound());
  }

  /// Every left node has one choice: the matching is known, and its energy is exact.
  double settled(const StarRelaxation& node) {
    Matching matching(state_.table().left_count(), unmatched);
    for (const uint32_t a : node.master()) matching[state_.table().left(a)] = a;
    state_.local().start_from(matching);
    double energy = 0.0;
    for (const uint32_t a : matching) {
      if (a == unmatched) continue;
      energy += state_.table().cost(a);
      for (const uint32_t b : matching) {
        if (b != unmatched) energy += 0.5 * state_.table().pair_cost(a, b);
      }
    }
    return std::max(energy, node.bound());
  }

  SearchState& state_;
  int64_t& branches_;
  std::function<bool()> stop_ = [this] { return state_.stop(); };
};

}  // namespace

double bound_by_ascent(SearchState& state, int64_t& branches) {
  const double bound = BranchAndBound(state, branches).run();
  // What was struck out costs more than the cutoff, and no more is known of it.
  return std::min(bound, state.cutoff());
}

}  // namespace kinemesh::graph_matching
