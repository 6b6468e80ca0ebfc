// A few left nodes, their assignments and the pairs between them, solved by exhaustive search.
// Internal to analysis/graph_matching.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "analysis/graph_matching/pair_table.h"

namespace kinemesh::graph_matching {

class LocalSubproblem {
 public:
  static constexpr std::size_t max_nodes = 5;

  /// Costs are 0 until set.
  LocalSubproblem(const PairTable& table, std::vector<uint32_t> left_nodes);

  const std::vector<uint32_t>& nodes() const { return nodes_; }
  /// Assignments of the node at `position`.
  std::span<const uint32_t> labels(std::size_t position) const { return labels_[position]; }
  double& cost(std::size_t position, std::size_t label) { return costs_[position][label]; }
  /// Cost of the pair of labels of two positions, first < second.
  double& pair_cost(std::size_t first, std::size_t second, std::size_t label_of_first,
                    std::size_t label_of_second) {
    return pairs_[first * max_nodes + second]
                 [label_of_first * labels_[second].size() + label_of_second];
  }
  std::size_t bytes() const;

  /// The least energy, where nodes may stay unmatched at no cost and each right node is used once.
  double solve();
  /// The label chosen for the node at `position`, or `unmatched`.
  uint32_t chosen(std::size_t position) const { return best_[position]; }

 private:
  void search(std::size_t position, double so_far);
  double with_earlier(std::size_t position, std::size_t label) const;

  const PairTable& table_;
  std::vector<uint32_t> nodes_;
  std::vector<std::vector<uint32_t>> labels_;
  std::vector<std::vector<double>> costs_;
  std::array<std::vector<double>, max_nodes * max_nodes> pairs_;
  std::array<double, max_nodes + 1> rest_{};  // the least that positions from here on can add
  std::array<uint32_t, max_nodes> now_{}, best_{};
  double best_energy_ = 0.0;
};

}  // namespace kinemesh::graph_matching
