#include "analysis/graph_matching/slack_assignment.h"

#include <algorithm>
#include <limits>

namespace kinemesh::graph_matching {
namespace {

constexpr uint32_t free_column = UINT32_MAX;
constexpr uint32_t unassigned = UINT32_MAX - 1;  // a row that has neither column nor slack yet

}  // namespace

SlackAssignment::SlackAssignment(uint32_t columns)
    : column_slack_(columns, 0.0),
      v_(columns, 0.0),
      row_of_(columns, free_column),
      distance_(columns, infinite),
      from_row_(columns, 0),
      state_(columns, 0) {}

void SlackAssignment::clear() {
  row_begin_.clear();
  columns_.clear();
  costs_.clear();
  row_slack_.clear();
  std::ranges::fill(column_slack_, 0.0);
}

void SlackAssignment::begin_row() {
  row_begin_.push_back(columns_.size());
  row_slack_.push_back(infinite);
}

/// Rows take their cheapest way where it is free.
void SlackAssignment::start() {
  row_begin_.push_back(columns_.size());
  std::ranges::fill(v_, 0.0);
  std::ranges::fill(row_of_, free_column);
  column_of_.assign(rows(), unassigned);
  u_.assign(rows(), 0.0);
  for (std::size_t k = 0; k < columns_.size(); ++k) costs_[k] -= column_slack_[columns_[k]];
  for (uint32_t r = 0; r < rows(); ++r) {
    double least = row_slack_[r];
    uint32_t column = none;
    for (std::size_t k = row_begin_[r]; k < row_begin_[r + 1]; ++k) {
      if (costs_[k] < least ||
          (costs_[k] == least && column != none && row_of_[column] != free_column)) {
        least = costs_[k];
        column = columns_[k];
      }
    }
    u_[r] = least;
    if (column == none) {
      if (least < infinite) column_of_[r] = none;
    } else if (row_of_[column] == free_column) {
      row_of_[column] = r;
      column_of_[r] = column;
    }
  }
}

void SlackAssignment::relax(uint32_t row, double distance) {
  const double base = distance - u_[row];
  if (base + row_slack_[row] < slack_distance_) {
    slack_distance_ = base + row_slack_[row];
    slack_row_ = row;
  }
  for (std::size_t k = row_begin_[row]; k < row_begin_[row + 1]; ++k) {
    const uint32_t c = columns_[k];
    if (state_[c] == 2) continue;
    const double there = base + costs_[k] - v_[c];
    if (!(there < distance_[c])) continue;
    distance_[c] = there;
    from_row_[c] = row;
    if (state_[c] == 0) {
      state_[c] = 1;
      open_.push_back(c);
    }
  }
}

/// Raises the duals along the search and flips the path that ends in a free column or row slack.
void SlackAssignment::finish(uint32_t free_row, uint32_t end_column, uint32_t end_row,
                             double distance) {
  for (const uint32_t c : done_) {
    v_[c] += distance_[c] - distance;
    u_[row_of_[c]] += distance - distance_[c];
  }
  u_[free_row] += distance;
  uint32_t column = end_column;
  if (end_row != none) {
    column = column_of_[end_row];
    column_of_[end_row] = none;
    if (end_row == free_row) return;
  }
  while (true) {
    const uint32_t row = from_row_[column];
    const uint32_t next = column_of_[row];
    row_of_[column] = row;
    column_of_[row] = column;
    if (row == free_row) return;
    column = next;
  }
}

bool SlackAssignment::augment(uint32_t row) {
  slack_distance_ = infinite;
  slack_row_ = none;
  open_.clear();
  done_.clear();
  if (u_[row] == infinite) return false;
  relax(row, 0.0);
  uint32_t end_column = none, end_row = none;
  double distance = infinite;
  while (true) {
    std::size_t nearest = open_.size();
    distance = slack_distance_;
    for (std::size_t k = 0; k < open_.size(); ++k) {
      if (distance_[open_[k]] < distance) {
        distance = distance_[open_[k]];
        nearest = k;
      }
    }
    if (nearest == open_.size()) {
      end_row = slack_row_;
      break;
    }
    const uint32_t c = open_[nearest];
    if (row_of_[c] == free_column) {
      end_column = c;
      break;
    }
    open_[nearest] = open_.back();
    open_.pop_back();
    done_.push_back(c);
    state_[c] = 2;
    relax(row_of_[c], distance);
  }
  const bool found = end_column != none || end_row != none;
  if (found) finish(row, end_column, end_row, distance);
  for (const std::vector<uint32_t>* touched : {&open_, &done_}) {
    for (const uint32_t c : *touched) {
      state_[c] = 0;
      distance_[c] = infinite;
    }
  }
  return found;
}

double SlackAssignment::solve(std::span<const uint32_t> counted_columns) {
  start();
  for (uint32_t r = 0; r < rows(); ++r) {
    if (column_of_[r] == unassigned && !augment(r)) return infinite;
  }
  double sum = 0.0;
  for (uint32_t r = 0; r < rows(); ++r) sum += u_[r];
  for (const uint32_t c : counted_columns) sum += v_[c] + column_slack_[c];
  return sum;
}

}  // namespace kinemesh::graph_matching
