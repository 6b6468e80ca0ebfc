// Dual decomposition as in the thesis 5.5.2 (Torresani, Kolmogorov & Rother 2013): a linear
// subproblem with all assignments, and a local one for each left node and its nearest neighbours,
// here those with which it shares the largest pair costs. Pairs that no neighbourhood holds get a
// subproblem of their own. The sum of the minima is a bound; projected subgradients raise it.
// Algorithm 5-2 joins the local solutions; where that breaks uniqueness, the assignment that more
// subproblems chose stays.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "analysis/graph_matching/local_subproblem.h"
#include "analysis/graph_matching/search_state.h"
#include "analysis/graph_matching/slack_assignment.h"
#include "config/error.h"

namespace kinemesh::graph_matching {
namespace {

class DualDecomposition {
 public:
  explicit DualDecomposition(SearchState& state)
      : state_(state),
        table_(state.table()),
        linear_(table_.size()),
        copies_(table_.size(), 1.0),
        votes_(table_.size(), 0.0),
        lap_(table_.right_count()) {
    for (uint32_t a = 0; a < table_.size(); ++a) linear_[a] = table_.cost(a);
    for (uint32_t j = 0; j < table_.right_count(); ++j) all_columns_.push_back(j);
    weigh_neighbours();
    choose_neighbourhoods();
    share_costs();
  }

  double run() {
    double best = -std::numeric_limits<double>::infinity();
    double pace = 1.0;
    int since_best = 0;
    while (true) {
      const double bound = solve_all();
      state_.count_iteration();
      if (bound > best) {
        best = bound;
        since_best = 0;
      } else if (++since_best > 20) {
        pace *= 0.7;
        since_best = 0;
      }
      state_.offer(repaired_union());
      if (best >= state_.cutoff() || pace < 1e-9 || state_.stop()) return best;
      step(pace * (state_.energy() - bound));
    }
  }

 private:
  using NodePair = std::pair<uint32_t, uint32_t>;
  static NodePair sorted(uint32_t i, uint32_t k) { return {std::min(i, k), std::max(i, k)}; }

  void weigh_neighbours() {
    for (uint32_t a = 0; a < table_.size(); ++a) {
      for (const PairTable::Entry& e : table_.row(a)) {
        weight_[sorted(table_.left(a), table_.left(e.other))] += std::abs(e.cost);
      }
    }
  }

  void choose_neighbourhoods() {
    std::vector<std::vector<std::pair<double, uint32_t>>> near(table_.left_count());
    for (const auto& [pair, weight] : weight_) {
      near[pair.first].emplace_back(-weight, pair.second);
      near[pair.second].emplace_back(-weight, pair.first);
    }
    const auto size = static_cast<std::size_t>(state_.options().local_size);
    for (uint32_t i = 0; i < near.size(); ++i) {
      if (near[i].empty()) continue;
      std::ranges::sort(near[i]);
      std::vector<uint32_t> nodes{i};
      for (std::size_t k = 0; k < near[i].size() && nodes.size() < size; ++k) {
        nodes.push_back(near[i][k].second);
      }
      add_subproblem(std::move(nodes));
    }
    for (const auto& [pair, weight] : weight_) {
      if (!holders_.contains(pair)) add_subproblem({pair.first, pair.second});
    }
  }

  void add_subproblem(std::vector<uint32_t> nodes) {
    std::ranges::sort(nodes);
    for (std::size_t x = 0; x < nodes.size(); ++x) {
      for (std::size_t y = x + 1; y < nodes.size(); ++y) {
        holders_[{nodes[x], nodes[y]}].push_back({static_cast<uint32_t>(locals_.size()),
                                                  static_cast<uint32_t>(x),
                                                  static_cast<uint32_t>(y)});
      }
    }
    locals_.emplace_back(table_, std::move(nodes));
    bytes_ += locals_.back().bytes();
    if (bytes_ > static_cast<std::size_t>(state_.options().memory_mb) * 1'000'000) {
      throw NoResultError({.what = "the local subproblems take more than " +
                                   std::to_string(state_.options().memory_mb) + " MB",
                           .remedy = "Raise --bound-memory, or use --matching-method ascent"});
    }
  }

  /// Pair costs in equal parts to the subproblems that hold the pair, an assignment's cost in equal
  /// parts to all that hold the assignment.
  void share_costs() {
    for (LocalSubproblem& local : locals_) {
      for (std::size_t x = 0; x < local.nodes().size(); ++x) {
        for (const uint32_t a : local.labels(x)) copies_[a] += 1.0;
      }
    }
    for (uint32_t a = 0; a < table_.size(); ++a) linear_[a] /= copies_[a];
    for (LocalSubproblem& local : locals_) {
      for (std::size_t x = 0; x < local.nodes().size(); ++x) {
        for (std::size_t k = 0; k < local.labels(x).size(); ++k) {
          local.cost(x, k) = linear_[local.labels(x)[k]];
        }
      }
    }
    for (const auto& [pair, holders] : holders_) {
      for (const Holder& h : holders) share_pair(h, 1.0 / static_cast<double>(holders.size()));
    }
  }

  struct Holder {
    uint32_t local, first, second;
  };
  void share_pair(const Holder& h, double part) {
    LocalSubproblem& local = locals_[h.local];
    const std::span<const uint32_t> firsts = local.labels(h.first);
    const std::span<const uint32_t> seconds = local.labels(h.second);
    for (std::size_t x = 0; x < firsts.size(); ++x) {
      for (std::size_t y = 0; y < seconds.size(); ++y) {
        local.pair_cost(h.first, h.second, x, y) = part * table_.pair_cost(firsts[x], seconds[y]);
      }
    }
  }

  double solve_all() {
    std::ranges::fill(votes_, 0.0);
    double bound = solve_linear();
    for (LocalSubproblem& local : locals_) {
      if (state_.stop()) return -std::numeric_limits<double>::infinity();
      bound += local.solve();
      for (std::size_t x = 0; x < local.nodes().size(); ++x) {
        if (local.chosen(x) != unmatched) votes_[local.labels(x)[local.chosen(x)]] += 1.0;
      }
    }
    return bound;
  }

  double solve_linear() {
    lap_.clear();
    std::vector<uint32_t> rows;
    for (uint32_t i = 0; i < table_.left_count(); ++i) {
      if (table_.of_left(i).empty()) continue;
      rows.push_back(i);
      lap_.begin_row();
      for (const uint32_t a : table_.of_left(i)) lap_.add(table_.right(a), linear_[a]);
      lap_.set_row_slack(0.0);
    }
    const double value = lap_.solve(all_columns_);
    linear_choice_.clear();
    for (uint32_t r = 0; r < rows.size(); ++r) {
      if (lap_.column_of(r) == SlackAssignment::none) continue;
      linear_choice_.push_back(table_.find(rows[r], lap_.column_of(r)));
      votes_[linear_choice_.back()] += 1.0;
    }
    return value;
  }

  std::vector<uint32_t> repaired_union() const {
    std::vector<uint32_t> order;
    for (uint32_t a = 0; a < votes_.size(); ++a) {
      if (votes_[a] > 0.0) order.push_back(a);
    }
    std::ranges::stable_sort(order, std::greater{}, [this](uint32_t a) { return votes_[a]; });
    std::vector<char> left(table_.left_count(), 0), right(table_.right_count(), 0);
    std::vector<uint32_t> chosen;
    for (const uint32_t a : order) {
      char& i = left[table_.left(a)];
      char& j = right[table_.right(a)];
      if (i != 0 || j != 0) continue;
      i = j = 1;
      chosen.push_back(a);
    }
    return chosen;
  }

  /// Moves each subproblem's costs along its choice's difference from the mean choice; the sum over
  /// subproblems stays what it was.
  void step(double distance) {
    double norm = 0.0;
    for (uint32_t a = 0; a < votes_.size(); ++a) {
      norm += votes_[a] - votes_[a] * votes_[a] / copies_[a];
    }
    norm += pair_norm();
    if (norm <= 0.0) return;
    const double size = distance / norm;
    for (uint32_t a = 0; a < votes_.size(); ++a) linear_[a] -= size * votes_[a] / copies_[a];
    for (const uint32_t a : linear_choice_) linear_[a] += size;
    for (LocalSubproblem& local : locals_) step_local(local, size);
    step_pairs(size);
  }

  void step_local(LocalSubproblem& local, double size) {
    for (std::size_t x = 0; x < local.nodes().size(); ++x) {
      const std::span<const uint32_t> labels = local.labels(x);
      for (std::size_t k = 0; k < labels.size(); ++k) {
        local.cost(x, k) -= size * votes_[labels[k]] / copies_[labels[k]];
      }
      if (local.chosen(x) != unmatched) local.cost(x, local.chosen(x)) += size;
    }
  }

  /// How often each pair of labels was chosen by the subproblems that hold a pair of nodes.
  std::map<NodePair, double> pair_votes(const std::vector<Holder>& holders) const {
    std::map<NodePair, double> votes;
    for (const Holder& h : holders) {
      const uint32_t x = locals_[h.local].chosen(h.first), y = locals_[h.local].chosen(h.second);
      if (x != unmatched && y != unmatched) votes[{x, y}] += 1.0;
    }
    return votes;
  }

  double pair_norm() const {
    double norm = 0.0;
    for (const auto& [pair, holders] : holders_) {
      if (holders.size() < 2) continue;
      for (const auto& [labels, count] : pair_votes(holders)) {
        norm += count - count * count / static_cast<double>(holders.size());
      }
    }
    return norm;
  }

  void step_pairs(double size) {
    for (const auto& [pair, holders] : holders_) {
      if (holders.size() < 2) continue;
      for (const auto& [labels, count] : pair_votes(holders)) {
        const double mean = count / static_cast<double>(holders.size());
        for (const Holder& h : holders) {
          LocalSubproblem& local = locals_[h.local];
          const bool mine =
              local.chosen(h.first) == labels.first && local.chosen(h.second) == labels.second;
          local.pair_cost(h.first, h.second, labels.first, labels.second) +=
              size * ((mine ? 1.0 : 0.0) - mean);
        }
      }
    }
  }

  SearchState& state_;
  const PairTable& table_;
  std::vector<double> linear_, copies_, votes_;
  std::vector<uint32_t> linear_choice_, all_columns_;
  SlackAssignment lap_;
  std::map<NodePair, double> weight_;
  std::map<NodePair, std::vector<Holder>> holders_;
  std::vector<LocalSubproblem> locals_;
  std::size_t bytes_ = 0;
};

}  // namespace

double bound_by_subgradient(SearchState& state) { return DualDecomposition(state).run(); }

}  // namespace kinemesh::graph_matching
