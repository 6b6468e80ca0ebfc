#include "analysis/feature_matching.h"

#include <algorithm>
#include <cmath>

#include "analysis/feature_energy.h"
#include "analysis/match_consensus.h"

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
       .help = "Take back matches that are this far, as a part of √area, from where the others say "
               "they are; 0: none"});
  p.choice("prior", prior,
           {{GeodesicPrior::none, "none", "not used"},
            {GeodesicPrior::printed, "printed", "both increase or both decrease (Algorithm 5-3)"},
            {GeodesicPrior::same_class, "same-class", "increase, decrease or do neither alike"}},
           "What the average distance along the path between two features must do on both");
  p.number("prior-tolerance", prior_tolerance,
           {.min = 0, .max = 1, .help = "Part of its range by which that may fall back"});
  p.number(
      "max-pairs", max_pairs,
      {.min = 1, .max = 1e9, .help = "Pairs of matches to compare at most (some 80 bytes each)"});
}

namespace {

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
    for (const uint32_t a : by_left_[i]) {
      if (a == now) continue;
      const uint32_t right = problem_.assignments[a].right;
      double change = gain_[a] - gain_[now];
      if (const uint32_t holder = at_right_[right]; holder != unmatched) {
        change -= gain_[holder] - between(now, holder);
      }
      if (change < best.second) best = {right, change};
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
    result.solution.certified = true;  // there is nothing else
    name_features(source, target, result);
    return result;
  }
  const FeatureEnergy energy(source, target, options);
  const MatchingProblem problem = energy.problem();
  result.assignments = problem.assignments.size();
  result.pairs = problem.pairs.size();
  result.solution = solve_matching(problem, solver, ctx);
  result.terms = energy.terms(result.solution.labelling);
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
  take_back_misfits(energy, options.reject, result.matches, result.rejected);
  fill_misfits(energy, result.matches);
  add_pair_terms(energy, result.matches);
  if (result.matches.empty()) {
    result.empty_reason =
        "leaving every feature unmatched costs least; lower the weights or raise "
        "--weight-matched";
  }
  name_features(source, target, result);
  return result;
}

}  // namespace kinemesh
