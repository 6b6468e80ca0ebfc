#include "analysis/graph_matching/local_subproblem.h"

#include <algorithm>

namespace kinemesh::graph_matching {

LocalSubproblem::LocalSubproblem(const PairTable& table, std::vector<uint32_t> left_nodes)
    : table_(table), nodes_(std::move(left_nodes)) {
  best_.fill(unmatched);
  for (const uint32_t i : nodes_) {
    const std::span<const uint32_t> mine = table.of_left(i);
    labels_.emplace_back(mine.begin(), mine.end());
    costs_.emplace_back(mine.size(), 0.0);
  }
  for (std::size_t first = 0; first < nodes_.size(); ++first) {
    for (std::size_t second = first + 1; second < nodes_.size(); ++second) {
      pairs_[first * max_nodes + second].assign(labels_[first].size() * labels_[second].size(),
                                                0.0);
    }
  }
}

std::size_t LocalSubproblem::bytes() const {
  std::size_t sum = 0;
  for (const std::vector<double>& pairs : pairs_) sum += pairs.size() * sizeof(double);
  return sum;
}

double LocalSubproblem::with_earlier(std::size_t position, std::size_t label) const {
  double sum = costs_[position][label];
  for (std::size_t earlier = 0; earlier < position; ++earlier) {
    if (now_[earlier] == unmatched) continue;
    sum += pairs_[earlier * max_nodes + position][now_[earlier] * labels_[position].size() + label];
  }
  return sum;
}

void LocalSubproblem::search(std::size_t position, double so_far) {
  if (so_far + rest_[position] >= best_energy_) return;
  if (position == nodes_.size()) {
    best_energy_ = so_far;
    best_ = now_;
    return;
  }
  for (std::size_t label = 0; label < labels_[position].size(); ++label) {
    const uint32_t right = table_.right(labels_[position][label]);
    bool taken = false;
    for (std::size_t earlier = 0; earlier < position; ++earlier) {
      taken |= now_[earlier] != unmatched && table_.right(labels_[earlier][now_[earlier]]) == right;
    }
    if (taken) continue;
    now_[position] = static_cast<uint32_t>(label);
    search(position + 1, so_far + with_earlier(position, label));
  }
  now_[position] = unmatched;
  search(position + 1, so_far);
}

double LocalSubproblem::solve() {
  rest_.fill(0.0);
  for (std::size_t position = nodes_.size(); position-- > 0;) {
    double least = 0.0;
    for (const double cost : costs_[position]) least = std::min(least, cost);
    for (std::size_t earlier = 0; earlier < position; ++earlier) {
      const std::vector<double>& pairs = pairs_[earlier * max_nodes + position];
      double pair = 0.0;
      for (const double cost : pairs) pair = std::min(pair, cost);
      least += pair;
    }
    rest_[position] = rest_[position + 1] + least;
  }
  now_.fill(unmatched);
  best_.fill(unmatched);
  best_energy_ = 0.0;  // nothing matched
  search(0, 0.0);
  return best_energy_;
}

}  // namespace kinemesh::graph_matching
