#include "analysis/feature_matching.h"

#include <algorithm>
#include <cmath>

#include "analysis/feature_energy.h"

namespace kinemesh {

void FeatureMatchingOptions::declare(ParameterSet& p) {
  p.group("match", "Matching of features");
  p.number("candidates", candidates,
           {.min = 0,
            .max = 1000,
            .help = "Candidates of each feature by descriptor (l of the thesis); 0: all"});
  p.number("neighbours", neighbours,
           {.min = 0,
            .max = 1000,
            .help = "Neighbours of each feature whose matches are compared with its own; 0: all"});
  p.number("coherence-neighbours", coherence_neighbours,
           {.min = 1, .max = 100, .help = "Neighbours in the coherence term"});
  p.number("weight-descriptor", descriptor,
           {.min = 0, .max = 1e3, .help = "Weight of the descriptors' difference"});
  p.number("weight-geodesic", geodesic,
           {.min = 0, .max = 1e3, .help = "Weight of the change of distances over the surface"});
  p.number("weight-orientation", orientation,
           {.min = 0,
            .max = 1e3,
            .help = "Weight of the twist between features, which tells left from right"});
  p.number("weight-matched", matched,
           {.min = 0, .max = 1e3, .help = "What an unmatched feature costs"});
  p.number("weight-coherence", coherence,
           {.min = 0, .max = 1e3, .help = "Weight of neighbours being matched or not alike"});
  p.number("weight-time", time_weight,
           {.min = 0, .max = 1e3, .help = "Weight of the moment beside each descriptor"});
  p.number(
      "reject", reject,
      {.min = 0,
       .max = 10,
       .help =
           "Take back matches whose distances to the others, near ones counting most, change by "
           "more than this part of √area in the mean; 0: none"});
  p.choice("prior", prior,
           {{GeodesicPrior::none, "none", "not used"},
            {GeodesicPrior::printed, "printed", "both increase or both decrease (Algorithm 5-3)"},
            {GeodesicPrior::same_class, "same-class", "increase, decrease or do neither alike"}},
           "What the average distance along the path between two features must do on both");
  p.number("prior-tolerance", prior_tolerance,
           {.min = 0, .max = 1, .help = "Part of its range by which that may fall back"});
  p.number("max-pairs", max_pairs,
           {.min = 1, .max = 1e9, .help = "Pairs of matches to compare at most (32 bytes each)"});
}

namespace {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Energies of whole matchings that differ in a match or two, from a table of all costs.
class Alternatives {
 public:
  explicit Alternatives(const MatchingProblem& problem) : problem_(problem), gain_(costs(problem)) {
    by_left_.resize(problem.left_count);
    for (uint32_t a = 0; a < problem.assignments.size(); ++a) {
      by_left_[problem.assignments[a].left].push_back(a);
    }
    rows_.resize(problem.assignments.size());
    for (const MatchingPair& e : problem.pairs) {
      rows_[e.a].push_back({e.b, e.cost});
      rows_[e.b].push_back({e.a, e.cost});
    }
  }

  void set_matching(std::span<const uint32_t> labelling) {
    chosen_ = problem_.chosen(labelling);
    at_right_.assign(problem_.right_count, unmatched);
    for (const uint32_t a : chosen_) {
      if (a == unmatched) continue;
      at_right_[problem_.assignments[a].right] = a;
      for (const auto& [b, cost] : rows_[a]) gain_[b] += cost;
    }
  }

  /// What the match of left node i adds.
  double energy_of(uint32_t i) const { return gain_[chosen_[i]]; }

  /// The best other right node of i and how much worse the energy is with it.
  std::pair<uint32_t, double> runner_up(uint32_t i) const {
    const uint32_t now = chosen_[i];
    std::pair<uint32_t, double> best{unmatched, -gain_[now]};
    bool first = true;
    for (const uint32_t a : by_left_[i]) {
      if (a == now) continue;
      const uint32_t right = problem_.assignments[a].right;
      double change = gain_[a] - gain_[now];
      if (const uint32_t holder = at_right_[right]; holder != unmatched) {
        change -= gain_[holder] - between(now, holder);
      }
      if (first || change < best.second) best = {right, change};
      first = false;
    }
    return best;
  }

 private:
  static std::vector<double> costs(const MatchingProblem& problem) {
    std::vector<double> result;
    for (const MatchingAssignment& a : problem.assignments) result.push_back(a.cost);
    return result;
  }
  double between(uint32_t a, uint32_t b) const {
    double sum = 0.0;
    for (const auto& [other, cost] : rows_[a]) sum += other == b ? cost : 0.0;
    return sum;
  }

  const MatchingProblem& problem_;
  std::vector<double> gain_;
  std::vector<std::vector<uint32_t>> by_left_;
  std::vector<std::vector<std::pair<uint32_t, double>>> rows_;
  std::vector<uint32_t> chosen_, at_right_;
};

/// How far matches are from where the others say, by distances over the surface and twists.
class Misfits {
 public:
  Misfits(const FeatureEnergy& energy, const std::vector<FeatureMatch>& matches)
      : energy_(energy), matches_(matches) {
    std::vector<double> ratios;
    for (std::size_t k = 0; k < matches.size(); ++k) {
      for (std::size_t o = 0; o < k; ++o) {
        const auto [a, b] = lengths(k, o);
        if (std::isfinite(a) && std::isfinite(b) && a > short_length) ratios.push_back(b / a);
      }
    }
    if (!ratios.empty()) scale_ = median(std::move(ratios));
  }

  /// The mean change of a match's distances and twists to the others, near ones counting most, in
  /// √area; the median ratio of all distances counts as a change of size.
  double of(std::size_t k) const {
    double sum = 0.0, weights = 0.0;
    for (std::size_t o = 0; o < matches_.size(); ++o) {
      const auto [a, b] = lengths(k, o);
      if (o == k || (!std::isfinite(a) && !std::isfinite(b))) continue;
      const bool same_part = std::isfinite(a) && std::isfinite(b);
      const double weight = same_part ? std::exp(-a / neighbourhood) : 1.0;
      const double twist = terms(k, o).orientation;
      sum += weight * (same_part ? std::abs(scale_ * a - b) + twist_weight * twist : 1.0);
      weights += weight;
    }
    return weights > 0.0 ? sum / weights : 0.0;
  }

 private:
  static constexpr double short_length = 0.1, neighbourhood = 0.3;  // √area
  static constexpr double twist_weight = 0.05;
  PairTerms terms(std::size_t k, std::size_t o) const {
    return energy_.pair(matches_[k].source, matches_[o].source, matches_[k].target,
                        matches_[o].target);
  }
  std::pair<double, double> lengths(std::size_t k, std::size_t o) const {
    return energy_.lengths(matches_[k].source, matches_[o].source, matches_[k].target,
                           matches_[o].target);
  }

  const FeatureEnergy& energy_;
  const std::vector<FeatureMatch>& matches_;
  double scale_ = 1.0;
};

void fill_misfits(const FeatureEnergy& energy, std::vector<FeatureMatch>& matches) {
  const Misfits misfits(energy, matches);
  for (std::size_t k = 0; k < matches.size(); ++k) matches[k].misfit = misfits.of(k);
}

/// Takes back the worst match until all fit the others.
void reject_outliers(const FeatureEnergy& energy, double limit, std::vector<FeatureMatch>& matches,
                     std::vector<FeatureMatch>& rejected) {
  while (limit > 0.0 && matches.size() > 3) {
    fill_misfits(energy, matches);
    const auto worst = std::ranges::max_element(matches, {}, &FeatureMatch::misfit);
    if (worst->misfit <= limit) return;
    rejected.push_back(*worst);
    matches.erase(worst);
  }
}

void add_pair_terms(const FeatureEnergy& energy, std::vector<FeatureMatch>& matches) {
  for (FeatureMatch& m : matches) {
    double geodesic = 0.0, orientation = 0.0;
    for (const FeatureMatch& o : matches) {
      if (&o == &m) continue;
      const PairTerms terms = energy.pair(m.source, o.source, m.target, o.target);
      geodesic += terms.geodesic;
      orientation += terms.orientation;
    }
    const double others = std::max(1.0, static_cast<double>(matches.size()) - 1.0);
    m.geodesic = geodesic / others;
    m.orientation = orientation / others;
  }
}

/// The weighted terms of (5-6) for the matches kept.
void sum_terms(const FeaturePlaces& source, const FeaturePlaces& target,
               const FeatureMatchingOptions& options, FeatureMatching& result) {
  const double smaller = static_cast<double>(std::min(source.places.size(), target.places.size()));
  const double count = static_cast<double>(result.matches.size());
  const double reach = (count - 1.0) / std::max(1.0, smaller - 1.0) / smaller;
  for (const FeatureMatch& m : result.matches) {
    result.descriptor += options.descriptor * m.descriptor / smaller;
    result.geodesic += options.geodesic * m.geodesic * reach;
    result.orientation += options.orientation * m.orientation * reach;
  }
  result.unmatched_part = options.matched * (1.0 - count / smaller);
  result.coherence = result.solution.energy / smaller - result.descriptor - result.geodesic -
                     result.orientation - result.unmatched_part;
}

/// From numbers of places to numbers of features.
void name_features(const FeaturePlaces& source, const FeaturePlaces& target,
                   FeatureMatching& result) {
  std::vector<char> left(source.places.size(), 0), right(target.places.size(), 0);
  for (FeatureMatch& m : result.matches) left[m.source] = right[m.target] = 1;
  for (std::vector<FeatureMatch>* list : {&result.matches, &result.rejected}) {
    for (FeatureMatch& m : *list) {
      m.source = source.places[m.source].index;
      m.target = target.places[m.target].index;
      if (m.runner_up != unmatched) m.runner_up = target.places[m.runner_up].index;
    }
  }
  for (std::size_t p = 0; p < left.size(); ++p) {
    if (left[p] == 0) result.unmatched_source.push_back(source.places[p].index);
  }
  for (std::size_t q = 0; q < right.size(); ++q) {
    if (right[q] == 0) result.unmatched_target.push_back(target.places[q].index);
  }
}

}  // namespace

FeatureMatching match_features(const FeaturePlaces& source, const FeaturePlaces& target,
                               const FeatureMatchingOptions& options, const MatchingOptions& solver,
                               const RunContext& ctx) {
  options.validate();
  FeatureMatching result;
  if (source.places.empty() || target.places.empty()) {
    result.empty_reason =
        source.places.empty() ? "the source has no features" : "the target has no features";
    name_features(source, target, result);
    return result;
  }
  const FeatureEnergy energy(source, target, options);
  const MatchingProblem problem = energy.problem();
  result.assignments = problem.assignments.size();
  result.pairs = problem.pairs.size();
  result.solution = solve_matching(problem, solver, ctx);
  Alternatives alternatives(problem);
  alternatives.set_matching(result.solution.labelling);
  for (uint32_t p = 0; p < problem.left_count; ++p) {
    const uint32_t q = result.solution.labelling[p];
    if (q == unmatched) continue;
    const auto [runner_up, margin] = alternatives.runner_up(p);
    result.matches.push_back({.source = p,
                              .target = q,
                              .descriptor = energy.descriptor(p, q),
                              .energy = alternatives.energy_of(p),
                              .runner_up = runner_up,
                              .margin = margin});
  }
  reject_outliers(energy, options.reject, result.matches, result.rejected);
  fill_misfits(energy, result.matches);
  add_pair_terms(energy, result.matches);
  sum_terms(source, target, options, result);
  if (result.matches.empty()) {
    result.empty_reason =
        "leaving every feature unmatched costs least; lower the weights or raise "
        "--weight-matched";
  }
  name_features(source, target, result);
  return result;
}

}  // namespace kinemesh
