#include "analysis/graph_matching/pair_table.h"

#include <algorithm>
#include <cmath>

#include "config/multiversion.h"

namespace kinemesh::graph_matching {
namespace {

KINEMESH_MULTIVERSION void add_scaled(const double* from, double sign, double* to,
                                      std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) to[k] += sign * from[k];
}

}  // namespace

PairTable::PairTable(const MatchingProblem& problem)
    : left_count_(problem.left_count), right_count_(problem.right_count) {
  for (const MatchingAssignment& it : problem.assignments) {
    left_.push_back(it.left);
    right_.push_back(it.right);
    cost_.push_back(it.cost);
  }
  fill_lefts();
  if (std::size_t{left_count_} * right_count_ <= indexed_nodes) {
    index_.assign(std::size_t{left_count_} * right_count_, unmatched);
    for (uint32_t a = 0; a < size(); ++a) {
      index_[std::size_t{left_[a]} * right_count_ + right_[a]] = a;
    }
  }
  fill_entries(problem);
  rescale();
  fill_dense();
}

void PairTable::fill_dense() {
  if (size() > dense_assignments) return;
  dense_.assign(std::size_t{size()} * size(), 0.0);
  for (uint32_t a = 0; a < size(); ++a) {
    for (const Entry& e : row(a)) dense_[std::size_t{a} * size() + e.other] = e.cost;
  }
}

void PairTable::fill_lefts() {
  left_begin_.assign(left_count_ + std::size_t{1}, 0);
  for (const uint32_t i : left_) ++left_begin_[i + 1];
  for (uint32_t i = 0; i < left_count_; ++i) left_begin_[i + 1] += left_begin_[i];
  by_left_.resize(size());
  std::vector<std::size_t> next(left_begin_.begin(), left_begin_.end() - 1);
  for (uint32_t a = 0; a < size(); ++a) by_left_[next[left_[a]]++] = a;
  for (uint32_t i = 0; i < left_count_; ++i) {
    std::sort(by_left_.begin() + static_cast<std::ptrdiff_t>(left_begin_[i]),
              by_left_.begin() + static_cast<std::ptrdiff_t>(left_begin_[i + 1]),
              [this](uint32_t a, uint32_t b) { return right_[a] < right_[b]; });
  }
}

void PairTable::fill_entries(const MatchingProblem& problem) {
  const auto counts = [this](const MatchingPair& p) {
    return left_[p.a] != left_[p.b] && right_[p.a] != right_[p.b];
  };
  std::vector<std::size_t> fill(size() + std::size_t{1}, 0);
  for (const MatchingPair& p : problem.pairs) {
    if (!counts(p)) continue;
    ++fill[p.a + std::size_t{1}];
    ++fill[p.b + std::size_t{1}];
  }
  for (uint32_t a = 0; a < size(); ++a) fill[a + 1] += fill[a];
  std::vector<Entry> all(fill.back());
  std::vector<std::size_t> next(fill.begin(), fill.end() - 1);
  for (const MatchingPair& p : problem.pairs) {
    if (!counts(p)) continue;
    all[next[p.a]++] = {p.b, p.cost};
    all[next[p.b]++] = {p.a, p.cost};
  }
  sort_rows(fill, all);
  merge_repeated(fill, std::move(all));
}

/// Files mostly name their pairs in order: then the rows are sorted already.
void PairTable::sort_rows(const std::vector<std::size_t>& begin, std::vector<Entry>& all) const {
  for (uint32_t a = 0; a < size(); ++a) {
    const std::span<Entry> row(all.data() + begin[a], begin[a + 1] - begin[a]);
    if (!std::ranges::is_sorted(row, {}, &Entry::other)) {
      std::ranges::stable_sort(row, {}, &Entry::other);
    }
  }
}

/// Costs of a pair that is named twice add up.
void PairTable::merge_repeated(const std::vector<std::size_t>& begin, std::vector<Entry> all) {
  begin_.assign(1, 0);
  std::size_t to = 0;
  for (uint32_t a = 0; a < size(); ++a) {
    for (std::size_t k = begin[a]; k < begin[a + 1]; ++k) {
      if (to > begin_[a] && all[to - 1].other == all[k].other) {
        all[to - 1].cost += all[k].cost;
      } else {
        all[to++] = all[k];
      }
    }
    begin_.push_back(to);
  }
  all.resize(to);
  entries_ = std::move(all);
}

/// No matching gains more than this in all.
double PairTable::most_gained() const {
  double gained = 0.0;
  bool forbids = false;
  for (const Entry& entry : entries_) {
    gained -= 0.5 * std::min(entry.cost, 0.0);  // each stands twice
    forbids |= entry.cost > 0.0;
  }
  for (const double cost : cost_) {
    gained -= std::min(cost, 0.0);
    forbids |= cost > 0.0;
  }
  if (!forbids) return gained;
  return std::min(gained, -simple_bound(*this, least_costs(*this, true)));
}

/// Brings costs to a range in which rounding does no harm. To choose what costs more than all that
/// can be gained is worse than to choose nothing, however much more it is.
void PairTable::rescale() {
  const double gained = most_gained();
  exponent_ = gained > 0.0 ? 10 - std::ilogb(gained) : 0;
  // In two steps: the power may be beyond what a number holds.
  const double half = std::ldexp(1.0, exponent_ / 2),
               rest = std::ldexp(1.0, exponent_ - exponent_ / 2);
  const double most = gained > 0.0 ? 2.0 * (gained * half * rest) : 1.0;
  for (double& cost : cost_) cost = std::min(cost * half * rest, most);
  for (Entry& entry : entries_) entry.cost = std::min(entry.cost * half * rest, most);
}

double PairTable::sum_of_magnitudes() const {
  double sum = 0.0;
  for (const Entry& entry : entries_) sum += 0.5 * std::abs(entry.cost);  // each stands twice
  for (const double cost : cost_) sum += std::abs(cost);
  return sum;
}

double PairTable::searched(uint32_t a, uint32_t b) const {
  const std::span<const Entry> entries = row(a);
  const auto it = std::ranges::lower_bound(entries, b, {}, &Entry::other);
  return it != entries.end() && it->other == b ? it->cost : 0.0;
}

void PairTable::add_row(uint32_t a, double sign, std::span<double> sums) const {
  const std::span<const Entry> entries = row(a);
  if (!dense_.empty() && 2 * entries.size() > sums.size()) {
    add_scaled(dense_.data() + std::size_t{a} * size(), sign, sums.data(), sums.size());
    return;
  }
  for (const Entry& e : entries) sums[e.other] += sign * e.cost;
}

uint32_t PairTable::find(uint32_t i, uint32_t j) const {
  if (!index_.empty()) return index_[std::size_t{i} * right_count_ + j];
  const std::span<const uint32_t> mine = of_left(i);
  const auto it = std::ranges::lower_bound(mine, j, {}, [this](uint32_t a) { return right_[a]; });
  return it != mine.end() && right_[*it] == j ? *it : unmatched;
}

std::vector<double> least_costs(const PairTable& table, bool gains_only) {
  std::vector<double> result(table.size()), least(table.left_count(), 0.0);
  for (uint32_t a = 0; a < table.size(); ++a) {
    result[a] = gains_only ? std::min(table.cost(a), 0.0) : table.cost(a);
    for (const PairTable::Entry& e : table.row(a)) {
      double& entry = least[table.left(e.other)];
      entry = std::min(entry, e.cost);
    }
    for (const PairTable::Entry& e : table.row(a)) {
      double& entry = least[table.left(e.other)];
      result[a] += 0.5 * entry;
      entry = 0.0;
    }
  }
  return result;
}

double simple_bound(const PairTable& table, std::span<const double> least) {
  double bound = 0.0;
  for (uint32_t i = 0; i < table.left_count(); ++i) {
    double best = 0.0;
    for (const uint32_t a : table.of_left(i)) best = std::min(best, least[a]);
    bound += best;
  }
  return bound;
}

}  // namespace kinemesh::graph_matching
