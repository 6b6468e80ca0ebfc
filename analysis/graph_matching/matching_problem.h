// Graph matching as Torresani, Kolmogorov & Rother (2013) state it: left nodes are assigned to
// right nodes, each at most once, so that the sum of the costs of the chosen assignments and of
// the chosen pairs of assignments is least. Leaving a node unmatched costs nothing.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace kinemesh {

/// In a labelling: this left node stays unmatched.
inline constexpr uint32_t unmatched = std::numeric_limits<uint32_t>::max();

/// A possible match and what choosing it costs (negative: a gain).
struct MatchingAssignment {
  uint32_t left = 0, right = 0;
  double cost = 0.0;
};

/// What choosing two assignments together costs. A pair of assignments that exclude each other
/// (same left or same right node) never counts.
struct MatchingPair {
  uint32_t a = 0, b = 0;  ///< indices into the assignments
  double cost = 0.0;
};

struct MatchingProblem {
  uint32_t left_count = 0, right_count = 0;
  std::vector<MatchingAssignment> assignments{};  ///< each (left, right) at most once
  std::vector<MatchingPair> pairs{};              ///< costs of a pair named twice add up
  double constant = 0.0;                          ///< added to every energy

  /// Throws InputError naming the assignment or pair for an index out of range, a cost that is not
  /// finite, a pair of an assignment with itself, or an assignment given twice; and when all costs
  /// together are more than a number can hold.
  void validate() const;
  /// For each left node the assignment that the labelling (right node or `unmatched`) chooses, or
  /// `unmatched`. Throws InputError when it is not one right node per left node, uses a right node
  /// twice, or a match that is no assignment.
  std::vector<uint32_t> chosen(std::span<const uint32_t> labelling) const;
  /// The energy of a labelling, summed afresh. Throws like chosen().
  double energy(std::span<const uint32_t> labelling) const;
};

}  // namespace kinemesh
