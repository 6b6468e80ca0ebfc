// How star relaxations come to be: from a problem, from a smaller reach, from one choice.
#include <algorithm>
#include <limits>

#include "analysis/graph_matching/star_relaxation.h"

namespace kinemesh::graph_matching {
namespace {

constexpr std::size_t few_entries = 100'000;  // below, stars over everything cost nothing

}  // namespace

StarRelaxation::StarRelaxation(const PairTable& table, std::size_t max_entries,
                               const std::function<bool()>& stop)
    : column_count_(table.right_count()), max_entries_(max_entries), lap_(table.right_count()) {
  make_elements(table);
  usable_ = make_entries(table, stop);
  if (usable_) link_back();
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

/// Which left nodes share pair costs, as a table; empty when that takes too much.
std::vector<char> StarRelaxation::sharing_rows(const PairTable& table) const {
  const std::size_t n = table.left_count();
  std::vector<char> near;
  if (n * n > max_entries_) return near;
  near.assign(n * n, 0);
  for (uint32_t a = 0; a < table.size(); ++a) {
    for (const PairTable::Entry& e : table.row(a)) {
      near[table.left(a) * n + table.left(e.other)] = 1;
    }
  }
  return near;
}

/// Returns false when it takes too much or is stopped.
bool StarRelaxation::make_entries(const PairTable& table, const std::function<bool()>& stop) {
  const std::size_t count = row_.size(), n = table.left_count();
  const std::vector<char> near = sharing_rows(table);
  const bool fits = count * count <= max_entries_;
  const auto shared = static_cast<std::size_t>(std::ranges::count(near, 1));
  columns_complete_ = fits && (count * count < few_entries || near.empty() || 2 * shared > n * n);
  if (!columns_complete_ && near.empty()) return false;
  begin_.assign(1, 0);
  if (columns_complete_) {
    other_.reserve(count * count);
    cost_.reserve(count * count);
  }
  for (uint32_t a = 0; a < count; ++a) {
    if (stop()) return false;
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
    if (other_.size() > max_entries_) return false;
    begin_.push_back(other_.size());
  }
  return true;
}

bool StarRelaxation::can_widen() const {
  return usable_ && !columns_complete_ && row_.size() * row_.size() <= max_entries_;
}

double StarRelaxation::width() const {
  const double all = static_cast<double>(row_.size()) * static_cast<double>(row_.size());
  return all / std::max(1.0, static_cast<double>(entries()));
}

bool StarRelaxation::widen(const std::function<bool()>& stop) {
  if (!can_widen()) return false;
  const std::size_t count = row_.size();
  std::vector<std::size_t> begin(1, 0);
  std::vector<uint32_t> other;
  std::vector<double> cost;
  other.reserve(count * count);
  cost.reserve(count * count);
  for (uint32_t a = 0; a < count; ++a) {
    if (stop()) return false;
    std::size_t e = begin_[a];
    for (uint32_t b = 0; b < count; ++b) {
      if (excludes(a, b)) continue;
      const bool known = e < begin_[a + 1] && other_[e] == b;
      other.push_back(b);
      cost.push_back(known ? cost_[e++] : 0.0);
    }
    begin.push_back(other.size());
  }
  begin_ = std::move(begin);
  other_ = std::move(other);
  cost_ = std::move(cost);
  columns_complete_ = true;
  link_back();
  return true;
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

StarRelaxation StarRelaxation::chosen(uint32_t element, const std::function<bool()>& stop) const {
  StarRelaxation rest;
  rest.column_count_ = column_count_;
  rest.max_entries_ = max_entries_;
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
  rest.usable_ = rest.copy_entries(*this, kept, stop);
  return rest;
}

bool StarRelaxation::copy_entries(const StarRelaxation& from, const std::vector<uint32_t>& kept,
                                  const std::function<bool()>& stop) {
  begin_.assign(1, 0);
  for (uint32_t a = 0; a < kept.size(); ++a) {
    if (kept[a] == none) continue;
    if (stop()) return false;
    for (std::size_t e = from.begin_[a]; e < from.begin_[a + 1]; ++e) {
      if (kept[from.other_[e]] == none) continue;
      other_.push_back(kept[from.other_[e]]);
      cost_.push_back(from.cost_[e]);
    }
    begin_.push_back(other_.size());
  }
  link_back();
  return true;
}

}  // namespace kinemesh::graph_matching
