#include "analysis/feature_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/descriptors.h"

namespace kinemesh {
namespace {

/// Deformation features by time, ties by vertex.
std::vector<std::size_t> in_order(const FeatureSet& set) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < set.features.size(); ++i) {
    if (set.features[i].kind == FeatureKind::deformation) order.push_back(i);
  }
  std::ranges::sort(order, [&](std::size_t x, std::size_t y) {
    const Feature& p = set.features[x];
    const Feature& q = set.features[y];
    return std::pair(p.frame, p.vertex) < std::pair(q.frame, q.vertex);
  });
  return order;
}

double relative_time(const FeatureSet& set, const Feature& f) {
  return set.frame_count > 1
             ? static_cast<double>(f.frame) / static_cast<double>(set.frame_count - 1)
             : 0.0;
}

double log_ratio(double a, double b) { return a > 0 && b > 0 ? std::abs(std::log(a / b)) : 0.0; }

double pair_cost(const FeatureSet& a, const Feature& p, const FeatureSet& b, const Feature& q,
                 const FeatureAlignmentOptions& options) {
  const double sigma = log_ratio(p.sigma_mm / std::max(a.diagonal_mm, 1e-12),
                                 q.sigma_mm / std::max(b.diagonal_mm, 1e-12));
  return options.scale * (sigma + log_ratio(p.tau_s, q.tau_s)) +
         options.descriptor * curve_distance(p.descriptor.deformation, q.descriptor.deformation) +
         options.time * std::abs(relative_time(a, p) - relative_time(b, q));
}

/// Gotoh's three tables: the last feature of A and of B are a pair, that of A has a gap beside it,
/// or that of B.
class Tables {
 public:
  enum State : uint8_t { pair, gap_a, gap_b };

  Tables(std::size_t n, std::size_t m, double open, double extend)
      : n_(n), m_(m), open_(open), extend_(extend) {
    for (auto& table : cost_) table.assign((n + 1) * (m + 1), infinite);
    for (auto& table : from_) table.assign((n + 1) * (m + 1), pair);
  }

  template <class Cost>
  void fill(Cost&& cost) {
    cost_[pair][0] = 0.0;
    for (std::size_t i = 0; i <= n_; ++i) {
      for (std::size_t j = 0; j <= m_; ++j) {
        if (i > 0 && j > 0) enter(pair, i, j, i - 1, j - 1, cost(i - 1, j - 1));
        if (i > 0) enter(gap_a, i, j, i - 1, j, 0.0);
        if (j > 0) enter(gap_b, i, j, i, j - 1, 0.0);
      }
    }
  }

  State best_end() const {
    State best = pair;
    for (const State s : {gap_a, gap_b}) {
      if (cost_[s][place(n_, m_)] < cost_[best][place(n_, m_)]) best = s;
    }
    return best;
  }
  double cost(State s) const { return cost_[s][place(n_, m_)]; }
  State before(State s, std::size_t i, std::size_t j) const {
    return static_cast<State>(from_[s][place(i, j)]);
  }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  std::size_t place(std::size_t i, std::size_t j) const { return i * (m_ + 1) + j; }

  void enter(State to, std::size_t i, std::size_t j, std::size_t pi, std::size_t pj, double cost) {
    for (const State from : {pair, gap_a, gap_b}) {
      const double gap = to == pair ? 0.0 : from == to ? extend_ : open_;
      const double total = cost_[from][place(pi, pj)] + cost + gap;
      if (total < cost_[to][place(i, j)]) {
        cost_[to][place(i, j)] = total;
        from_[to][place(i, j)] = from;
      }
    }
  }

  std::size_t n_, m_;
  double open_, extend_;
  std::array<std::vector<double>, 3> cost_;
  std::array<std::vector<uint8_t>, 3> from_;
};

double run_of_gaps(std::size_t count, const FeatureAlignmentOptions& options) {
  return count == 0 ? 0.0 : options.gap_open + static_cast<double>(count - 1) * options.gap_extend;
}

}  // namespace

void FeatureAlignmentOptions::declare(ParameterSet& p) {
  p.group("sequence", "Alignment of feature sequences");
  const auto weight = [&p](const char* name, double& field, const char* help) {
    p.number(name, field, {.min = 0.0, .max = 100.0, .help = help});
  };
  weight("gap-open", gap_open, "cost of the first feature of a run without counterpart");
  weight("gap-extend", gap_extend, "cost of each further feature of the run");
  weight("scale-weight", scale, "weight of the difference of the features' scales");
  weight("descriptor-weight", descriptor, "weight of the difference of their deformation curves");
  weight("time-weight", time, "weight of the difference of their times");
}

FeatureAlignment align_features(const FeatureSet& a, const FeatureSet& b,
                                const FeatureAlignmentOptions& options) {
  options.validate();
  const std::vector<std::size_t> first = in_order(a), second = in_order(b);
  const auto cost = [&](std::size_t i, std::size_t j) {
    return pair_cost(a, a.features[first[i]], b, b.features[second[j]], options);
  };
  Tables tables(first.size(), second.size(), options.gap_open, options.gap_extend);
  tables.fill(cost);
  FeatureAlignment result;
  Tables::State state = tables.best_end();
  const double total = tables.cost(state);
  for (std::size_t i = first.size(), j = second.size(); i > 0 || j > 0;) {
    const Tables::State previous = tables.before(state, i, j);
    if (state == Tables::pair) {
      --i, --j;
      result.pairs.push_back({first[i], second[j], cost(i, j)});
      result.pair_cost += result.pairs.back().cost;
    } else if (state == Tables::gap_a) {
      result.only_a.push_back(first[--i]);
    } else {
      result.only_b.push_back(second[--j]);
    }
    state = previous;
  }
  std::ranges::reverse(result.pairs);
  std::ranges::reverse(result.only_a);
  std::ranges::reverse(result.only_b);
  result.gap_cost = total - result.pair_cost;
  const double nothing = run_of_gaps(first.size(), options) + run_of_gaps(second.size(), options);
  result.similarity = nothing > 0 ? 1.0 - std::min(1.0, total / nothing) : 1.0;
  return result;
}

}  // namespace kinemesh
