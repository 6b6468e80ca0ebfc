// The dual side: one linear assignment for every assignment ("star"), and one above them all.
// Internal to analysis/graph_matching.
//
// The level-1 reformulation of Adams & Johnson (1994) by dual ascent (Hahn & Grant 1998), here for
// partial matchings: staying unmatched is an element of its row or column like any assignment. The
// cost of a pair is split between the stars of its two elements. Solving a star moves cost from
// its pairs to its element, solving the master assignment moves cost from the elements to the
// bound; what remains is never negative, so the bound holds at any time, and whatever would lift it
// over a known energy can be struck out.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "analysis/graph_matching/pair_table.h"
#include "analysis/graph_matching/slack_assignment.h"

namespace kinemesh::graph_matching {

class StarRelaxation {
 public:
  static constexpr uint32_t none = UINT32_MAX;

  /// `max_entries` bounds the memory (16 bytes an entry): above it, and where few left nodes share
  /// pair costs, stars reach only over those that do; usable() is false when even that is too much
  /// or `stop` asked to end.
  StarRelaxation(const PairTable& table, std::size_t max_entries,
                 const std::function<bool()>& stop);

  bool usable() const { return usable_; }
  std::size_t entries() const { return other_.size(); }
  /// No matching that is left has a smaller energy; minus infinity before the first sweep ends.
  double bound() const { return nonnegative_ ? bound_ : -std::numeric_limits<double>::infinity(); }

  /// Whether stars reach over a part only, and there is memory for the whole.
  bool can_widen() const;
  /// How many times as much there is over everything.
  double width() const;
  /// Lets stars reach over everything, which bounds better and takes longer; false when stopped.
  bool widen(const std::function<bool()>& stop);

  /// A first bound at little cost; false when stopped.
  bool lower_rows(const std::function<bool()>& stop);
  /// One pass over all stars and the master. `cutoff`: only energies below it matter. Returns false
  /// when `stop` asked to end; the bound stays valid.
  bool sweep(double cutoff, const std::function<bool()>& stop);
  /// The assignments that the last master chose.
  const std::vector<uint32_t>& master() const { return master_; }

  /// The elements of the left node to branch on, most promising first; empty when all is settled.
  std::vector<uint32_t> branch_elements() const;
  /// What the bound is at least when the element is chosen.
  double bound_with(uint32_t element) const { return bound_ + reduced_[element]; }
  /// The rest of the problem once the element is chosen (`none`: nothing but a smaller copy).
  /// Not usable when `stop` asked to end.
  StarRelaxation chosen(uint32_t element, const std::function<bool()>& stop) const;
  bool many_struck_out() const;

 private:
  StarRelaxation() = default;
  void make_elements(const PairTable& table);
  std::vector<char> sharing_rows(const PairTable& table) const;
  bool make_entries(const PairTable& table, const std::function<bool()>& stop);
  bool copy_entries(const StarRelaxation& from, const std::vector<uint32_t>& kept,
                    const std::function<bool()>& stop);
  void link_back();
  bool excludes(uint32_t a, uint32_t b) const;
  bool solve_star(uint32_t a, double cutoff);
  void gather(uint32_t a);
  void scatter(uint32_t a, double cutoff);
  void solve_master();
  void strike_out(double cutoff);
  void spread_star(uint32_t a);

  uint32_t column_count_ = 0;
  std::size_t max_entries_ = 0;
  bool usable_ = true, columns_complete_ = true, nonnegative_ = false, forward_ = true;
  double bound_ = 0.0;
  // Elements: rows in order, each with its assignments and then its slack; column slacks last.
  std::vector<uint32_t> row_, column_, assignment_;
  std::vector<char> alive_;
  std::vector<double> theta_, reduced_;
  std::vector<uint32_t> fixed_, master_;  // assignments
  // Entries of each star by ascending other element.
  std::vector<std::size_t> begin_;
  std::vector<uint32_t> other_, back_;
  std::vector<double> cost_;
  // workspace
  std::vector<uint32_t> star_columns_;
  std::vector<uint32_t> row_index_;
  SlackAssignment lap_{0};
};

}  // namespace kinemesh::graph_matching
