// The pair costs of a matching problem by assignment, for local search. Internal to
// analysis/graph_matching.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "analysis/graph_matching/matching_problem.h"

namespace kinemesh::graph_matching {

/// The symmetric table of pair costs; pairs that exclude each other are left out. Dense up to
/// `dense_assignments`, else rows of sorted entries.
class PairTable {
 public:
  static constexpr std::size_t dense_assignments = 4096;
  static constexpr std::size_t indexed_nodes = std::size_t{1} << 22;  ///< left × right nodes

  explicit PairTable(const MatchingProblem& problem);

  uint32_t left_count() const { return left_count_; }
  uint32_t right_count() const { return right_count_; }
  uint32_t size() const { return static_cast<uint32_t>(cost_.size()); }
  uint32_t left(uint32_t a) const { return left_[a]; }
  uint32_t right(uint32_t a) const { return right_[a]; }
  double cost(uint32_t a) const { return cost_[a]; }

  /// All costs here are those of the problem times 2^exponent: what can be gained at most comes to
  /// about a thousand. Costs above twice that, which forbid, are lowered to it.
  int exponent() const { return exponent_; }
  /// The sum of what all costs amount to.
  double sum_of_magnitudes() const;

  struct Entry {
    uint32_t other;
    double cost;
  };
  /// The pairs of `a` by ascending other assignment.
  std::span<const Entry> row(uint32_t a) const {
    return {entries_.data() + begin_[a], begin_[a + 1] - begin_[a]};
  }
  double pair_cost(uint32_t a, uint32_t b) const {
    return dense_.empty() ? searched(a, b) : dense_[std::size_t{a} * size() + b];
  }
  /// Adds `sign` × the pair costs of `a` to `sums`, one per assignment.
  void add_row(uint32_t a, double sign, std::span<double> sums) const;

  /// Assignments of a left node, by ascending right node.
  std::span<const uint32_t> of_left(uint32_t i) const {
    return {by_left_.data() + left_begin_[i], left_begin_[i + 1] - left_begin_[i]};
  }
  /// The assignment of i to j, or `unmatched`.
  uint32_t find(uint32_t i, uint32_t j) const;

 private:
  double searched(uint32_t a, uint32_t b) const;
  void fill_lefts();
  void fill_entries(const MatchingProblem& problem);
  void rescale();
  double most_gained() const;
  void fill_dense();
  void sort_rows(const std::vector<std::size_t>& begin, std::vector<Entry>& all) const;
  void merge_repeated(const std::vector<std::size_t>& begin, std::vector<Entry> all);

  uint32_t left_count_, right_count_;
  int exponent_ = 0;
  std::vector<uint32_t> left_, right_;
  std::vector<double> cost_;
  std::vector<std::size_t> begin_;
  std::vector<Entry> entries_;
  std::vector<double> dense_;
  std::vector<std::size_t> left_begin_;
  std::vector<uint32_t> by_left_;
  std::vector<uint32_t> index_;  // assignment by left and right node; empty for very many
};

/// What each assignment costs at least, with half of each pair at its best; without its own cost
/// where that is positive, when only gains count.
std::vector<double> least_costs(const PairTable& table, bool gains_only = false);
/// A bound that needs no iteration, from least_costs().
double simple_bound(const PairTable& table, std::span<const double> least);

}  // namespace kinemesh::graph_matching
