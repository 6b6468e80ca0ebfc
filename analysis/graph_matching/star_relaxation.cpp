#include "analysis/graph_matching/star_relaxation.h"

#include <algorithm>
#include <limits>

namespace kinemesh::graph_matching {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace

StarRelaxation::StarRelaxation(const PairTable& table, std::size_t max_entries)
    : column_count_(table.right_count()), lap_(table.right_count()) {
  make_elements(table);
  make_entries(table, max_entries);
}

void StarRelaxation::make_elements(const PairTable& table) {
  const auto add = [this](uint32_t row, uint32_t column, uint32_t assignment, double cost) {
    row_.push_back(row);
    column_.push_back(column);
    assignment_.push_back(assignment);
    theta_.push_back(cost);
  };
  std::vector<char> used(column_count_, 0);
  for (uint32_t i = 0; i < table.left_count(); ++i) {
    if (table.of_left(i).empty()) continue;
    for (const uint32_t a : table.of_left(i)) {
      add(i, table.right(a), a, table.cost(a));
      used[table.right(a)] = 1;
    }
    add(i, none, none, 0.0);
  }
  for (uint32_t j = 0; j < column_count_; ++j) {
    if (used[j] != 0) add(none, j, none, 0.0);
  }
  alive_.assign(row_.size(), 1);
}

bool StarRelaxation::excludes(uint32_t a, uint32_t b) const {
  return (row_[a] == row_[b] && row_[a] != none) ||
         (column_[a] == column_[b] && column_[a] != none);
}

void StarRelaxation::make_entries(const PairTable& table, std::size_t max_entries) {
  const std::size_t count = row_.size();
  columns_complete_ = count * count <= max_entries;
  // Which left nodes share pair costs; all of them when there is room.
  const std::size_t n = table.left_count();
  std::vector<char> near;
  if (!columns_complete_) {
    if (n * n > max_entries) {
      usable_ = false;
      return;
    }
    near.assign(n * n, 0);
    for (uint32_t a = 0; a < table.size(); ++a) {
      for (const PairTable::Entry& e : table.row(a))
        near[table.left(a) * n + table.left(e.other)] = 1;
    }
  }
  begin_.assign(1, 0);
  for (uint32_t a = 0; a < count; ++a) {
    for (uint32_t b = 0; b < count; ++b) {
      if (excludes(a, b)) continue;
      if (!columns_complete_ &&
          (row_[a] == none || row_[b] == none || near[row_[a] * n + row_[b]] == 0)) {
        continue;
      }
      const bool real = assignment_[a] != none && assignment_[b] != none;
      other_.push_back(b);
      cost_.push_back(real ? 0.5 * table.pair_cost(assignment_[a], assignment_[b]) : 0.0);
    }
    if (other_.size() > max_entries) {
      usable_ = false;
      return;
    }
    begin_.push_back(other_.size());
  }
  link_back();
}

/// Stars are visited in the order in which their entries stand in the other stars.
void StarRelaxation::link_back() {
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  back_.resize(other_.size());
  for (uint32_t a = 0; a < row_.size(); ++a) {
    for (std::size_t e = begin_[a]; e < begin_[a + 1]; ++e) {
      back_[e] = static_cast<uint32_t>(next[other_[e]]++);
    }
  }
  reduced_ = theta_;
}

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

StarRelaxation StarRelaxation::chosen(uint32_t element) const {
  StarRelaxation rest;
  rest.column_count_ = column_count_;
  rest.columns_complete_ = columns_complete_;
  rest.nonnegative_ = nonnegative_;
  rest.bound_ = bound_;
  rest.fixed_ = fixed_;
  rest.lap_ = SlackAssignment(column_count_);
  std::vector<double> added(row_.size(), 0.0);
  if (element != none) {
    rest.bound_ += theta_[element];
    if (assignment_[element] != none) rest.fixed_.push_back(assignment_[element]);
    for (std::size_t e = begin_[element]; e < begin_[element + 1]; ++e) {
      added[other_[e]] = cost_[e] + cost_[back_[e]];
    }
  }
  std::vector<uint32_t> kept(row_.size(), none);
  for (uint32_t a = 0; a < row_.size(); ++a) {
    if (alive_[a] == 0 || added[a] == infinite) continue;
    if (element != none && (a == element || excludes(a, element))) continue;
    kept[a] = static_cast<uint32_t>(rest.row_.size());
    rest.row_.push_back(row_[a]);
    rest.column_.push_back(column_[a]);
    rest.assignment_.push_back(assignment_[a]);
    rest.theta_.push_back(theta_[a] + added[a]);
  }
  rest.alive_.assign(rest.row_.size(), 1);
  rest.copy_entries(*this, kept);
  return rest;
}

void StarRelaxation::copy_entries(const StarRelaxation& from, const std::vector<uint32_t>& kept) {
  begin_.assign(1, 0);
  for (uint32_t a = 0; a < kept.size(); ++a) {
    if (kept[a] == none) continue;
    for (std::size_t e = from.begin_[a]; e < from.begin_[a + 1]; ++e) {
      if (kept[from.other_[e]] == none) continue;
      other_.push_back(kept[from.other_[e]]);
      cost_.push_back(from.cost_[e]);
    }
    begin_.push_back(other_.size());
  }
  link_back();
}

}  // namespace kinemesh::graph_matching
