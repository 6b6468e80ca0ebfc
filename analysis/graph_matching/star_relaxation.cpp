#include "analysis/graph_matching/star_relaxation.h"

#include <algorithm>

namespace kinemesh::graph_matching {

/// Collects what both stars hold of a's pairs into the linear assignment of star a.
void StarRelaxation::gather(uint32_t a) {
  lap_.clear();
  star_columns_.clear();
  row_index_.clear();
  uint32_t row = none;
  for (std::size_t e = begin_[a]; e < begin_[a + 1]; ++e) {
    const uint32_t b = other_[e];
    double& mine = cost_[e];
    double& theirs = cost_[back_[e]];
    if (alive_[b] == 0 || mine == infinite || theirs == infinite) {
      mine = infinite;
      theirs = infinite;
    } else {
      mine += theirs;
      theirs = 0.0;
    }
    if (row_[b] != row && row_[b] != none) {
      row = row_[b];
      lap_.begin_row();
    }
    if (row_[b] == none) {
      lap_.set_column_slack(column_[b], mine == infinite ? 0.0 : mine);
      star_columns_.push_back(column_[b]);
    } else if (column_[b] == none) {
      lap_.set_row_slack(mine);
    } else {
      lap_.add(column_[b], mine);
      if (!columns_complete_) star_columns_.push_back(column_[b]);
    }
    row_index_.push_back(lap_.rows() - 1);
  }
  if (!columns_complete_) {  // each column once
    std::ranges::sort(star_columns_);
    star_columns_.erase(std::unique(star_columns_.begin(), star_columns_.end()),
                        star_columns_.end());
  }
}

/// Leaves the reduced costs with star a, and strikes out pairs that would lift the bound too far.
void StarRelaxation::scatter(uint32_t a, double cutoff) {
  const double base = bound_ + theta_[a];
  for (std::size_t e = begin_[a]; e < begin_[a + 1]; ++e) {
    if (cost_[e] == infinite) continue;
    const uint32_t b = other_[e];
    if (row_[b] != none) cost_[e] -= lap_.row_dual(row_index_[e - begin_[a]]);
    if (column_[b] != none) cost_[e] -= lap_.column_dual(column_[b]);
    if (nonnegative_ && row_[b] != none && row_[a] != none &&
        base + theta_[b] + cost_[e] > cutoff) {
      cost_[e] = infinite;
      cost_[back_[e]] = infinite;
    }
  }
}

bool StarRelaxation::solve_star(uint32_t a, double cutoff) {
  gather(a);
  const double value = lap_.solve(star_columns_);
  if (value == infinite) return false;
  theta_[a] += value;
  scatter(a, cutoff);
  return true;
}

void StarRelaxation::solve_master() {
  lap_.clear();
  star_columns_.clear();
  row_index_.clear();
  uint32_t row = none;
  for (uint32_t a = 0; a < row_.size(); ++a) {
    if (row_[a] != row && row_[a] != none) {
      row = row_[a];
      lap_.begin_row();
    }
    row_index_.push_back(lap_.rows() - 1);
    if (row_[a] == none) {
      lap_.set_column_slack(column_[a], theta_[a]);
      star_columns_.push_back(column_[a]);
    } else if (alive_[a] != 0) {
      column_[a] == none ? lap_.set_row_slack(theta_[a]) : lap_.add(column_[a], theta_[a]);
    }
  }
  const double value = lap_.solve(star_columns_);
  bound_ += value;
  if (value == infinite) return;
  master_ = fixed_;
  for (uint32_t a = 0; a < row_.size(); ++a) {
    if (alive_[a] == 0) continue;
    if (row_[a] != none) theta_[a] -= lap_.row_dual(row_index_[a]);
    if (column_[a] != none) theta_[a] -= lap_.column_dual(column_[a]);
    if (assignment_[a] != none && lap_.column_of(row_index_[a]) == column_[a]) {
      master_.push_back(assignment_[a]);
    }
  }
}

void StarRelaxation::strike_out(double cutoff) {
  for (uint32_t a = 0; a < row_.size(); ++a) {
    if (row_[a] != none && bound_ + theta_[a] > cutoff) alive_[a] = 0;
  }
  reduced_ = theta_;
}

/// Gives an element's cost back to its pairs: choosing it means one choice in every other row and
/// column.
void StarRelaxation::spread_star(uint32_t a) {
  std::size_t groups = 0;
  uint32_t row = none;
  for (std::size_t e = begin_[a]; e < begin_[a + 1]; ++e) {
    const uint32_t b = other_[e];
    if (row_[b] == none) {
      ++groups;
    } else if (row_[b] != row) {
      row = row_[b];
      ++groups;
    }
  }
  if (groups == 0) return;
  const double share = theta_[a] / static_cast<double>(groups);
  for (std::size_t e = begin_[a]; e < begin_[a + 1]; ++e) {
    const uint32_t b = other_[e];
    const bool both = columns_complete_ && row_[b] != none && column_[b] != none;
    cost_[e] += both ? 2.0 * share : share;
  }
  theta_[a] = 0.0;
}

/// Takes the least cost of every row out of each star: a bound at little cost, from which on any
/// sweep may be interrupted.
bool StarRelaxation::lower_rows(const std::function<bool()>& stop) {
  for (uint32_t a = 0; a < row_.size(); ++a) {
    if (stop()) return false;
    for (std::size_t first = begin_[a]; first < begin_[a + 1];) {
      std::size_t last = first;
      double least = infinite;
      for (; last < begin_[a + 1] && row_[other_[last]] == row_[other_[first]]; ++last) {
        least = std::min(least, cost_[last]);
      }
      if (row_[other_[first]] != none) {
        for (std::size_t e = first; e < last; ++e) cost_[e] -= least;
        theta_[a] += least;
      }
      first = last;
    }
  }
  solve_master();
  nonnegative_ = true;
  reduced_ = theta_;
  for (uint32_t a = 0; a < row_.size(); ++a) spread_star(a);
  return true;
}

/// After each row of stars, what the master does not need goes back to their pairs, so that the
/// next rows find it.
bool StarRelaxation::sweep(double cutoff, const std::function<bool()>& stop) {
  const uint32_t count = static_cast<uint32_t>(row_.size());
  std::vector<uint32_t> group;
  const auto close_group = [&] {
    solve_master();
    for (const uint32_t a : group) spread_star(a);
    group.clear();
  };
  for (uint32_t k = 0; k < count; ++k) {
    const uint32_t a = forward_ ? k : count - 1 - k;
    if (!group.empty() && row_[a] != row_[group.back()]) close_group();
    if (alive_[a] == 0) continue;
    if (stop()) return false;
    if (solve_star(a, cutoff)) {
      group.push_back(a);
    } else if (row_[a] != none) {
      alive_[a] = 0;
    }
  }
  forward_ = !forward_;
  solve_master();
  nonnegative_ = true;
  strike_out(cutoff);
  return true;
}

std::vector<uint32_t> StarRelaxation::branch_elements() const {
  std::vector<uint32_t> best, current;
  double best_sum = 0.0;
  const auto close_row = [&] {
    double sum = 0.0;
    for (const uint32_t a : current) sum += reduced_[a];
    if (current.size() > 1 && (best.empty() || current.size() < best.size() ||
                               (current.size() == best.size() && sum > best_sum))) {
      best = current;
      best_sum = sum;
    }
    current.clear();
  };
  for (uint32_t a = 0; a < row_.size() && row_[a] != none; ++a) {
    if (!current.empty() && row_[current.back()] != row_[a]) close_row();
    if (alive_[a] != 0) current.push_back(a);
  }
  close_row();
  std::ranges::stable_sort(best, {}, [this](uint32_t a) { return reduced_[a]; });
  return best;
}

bool StarRelaxation::many_struck_out() const {
  return 5 * static_cast<std::size_t>(std::ranges::count(alive_, 0)) > alive_.size();
}

}  // namespace kinemesh::graph_matching
