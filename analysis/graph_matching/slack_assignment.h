// Sparse linear assignment in which rows and columns may stay unmatched at a cost, with its dual.
// Internal to analysis/graph_matching.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace kinemesh::graph_matching {

/// The cost of what is ruled out.
inline constexpr double infinite = std::numeric_limits<double>::infinity();

/// Minimises Σ cost(r,c) x(r,c) + Σ slack(r) x(r,–) + Σ slack(c) x(–,c), every row and column
/// covered once. Shortest augmenting paths (Jonker & Volgenant 1987) over sparse rows. Costs may be
/// infinite; column slacks are finite. A workspace that is filled anew for each problem.
class SlackAssignment {
 public:
  static constexpr uint32_t none = UINT32_MAX;  ///< a row that is matched to its slack

  explicit SlackAssignment(uint32_t columns);

  void clear();
  /// Adds a row whose slack is forbidden until set_row_slack() is called.
  void begin_row();
  void add(uint32_t column, double cost) {
    columns_.push_back(column);
    costs_.push_back(cost);
  }
  void set_row_slack(double cost) { row_slack_.back() = cost; }
  void set_column_slack(uint32_t column, double cost) { column_slack_[column] = cost; }

  /// The least cost, with column slacks counted for the columns that `counted` names; infinite
  /// when there is no solution.
  double solve(std::span<const uint32_t> counted_columns);

  uint32_t rows() const { return static_cast<uint32_t>(row_slack_.size()); }
  /// Duals: cost(r,c) - row_dual(r) - column_dual(c) ≥ 0, slack(r) ≥ row_dual(r), and so on.
  double row_dual(uint32_t r) const { return u_[r]; }
  double column_dual(uint32_t c) const { return v_[c] + column_slack_[c]; }
  /// The row's column, or `none`.
  uint32_t column_of(uint32_t r) const { return column_of_[r]; }

 private:
  void start();
  bool augment(uint32_t row);
  void relax(uint32_t row, double distance);
  void finish(uint32_t free_row, uint32_t end_column, uint32_t end_row, double distance);

  std::vector<std::size_t> row_begin_;
  std::vector<uint32_t> columns_;
  std::vector<double> costs_, row_slack_, column_slack_;
  std::vector<double> u_, v_;
  std::vector<uint32_t> column_of_, row_of_;
  // one search
  std::vector<double> distance_;
  std::vector<uint32_t> from_row_, open_, done_;
  std::vector<char> state_;  // 0 untouched, 1 open, 2 done
  double slack_distance_ = 0.0;
  uint32_t slack_row_ = none;
};

}  // namespace kinemesh::graph_matching
