// The energy of matching features (thesis 5-6) as a graph matching problem. Internal to analysis.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "analysis/feature_matching.h"

namespace kinemesh {

/// Costs of one pair of matches, before weighting.
struct PairTerms {
  double geodesic = 0.0;     ///< relative distortion, at most 2
  double orientation = 0.0;  ///< twist difference, 0 to 2
  bool prior_broken = false;
};

/// The terms between two sets of places.
class FeatureEnergy {
 public:
  FeatureEnergy(const FeaturePlaces& source, const FeaturePlaces& target,
                const FeatureMatchingOptions& options);

  const FeaturePlaces& source() const { return source_; }
  const FeaturePlaces& target() const { return target_; }
  /// θ of a match.
  double descriptor(std::size_t p, std::size_t q) const {
    return descriptor_(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(q));
  }
  /// Geodesic lengths between two features of each side, √area.
  std::pair<double, double> lengths(std::size_t p, std::size_t p2, std::size_t q,
                                    std::size_t q2) const;
  PairTerms pair(std::size_t p, std::size_t p2, std::size_t q, std::size_t q2) const;

  /// The problem, its energy being that of (5-6) times the smaller count. Throws NoResultError when
  /// it would be too large.
  MatchingProblem problem() const;
  /// `labelling`: the target's place of each of the source's, or `unmatched`.
  EnergyTerms terms(std::span<const uint32_t> labelling) const;

 private:
  using Near = std::vector<std::vector<char>>;
  /// Which features are compared, and which are matched or not alike.
  struct Neighbourhoods {
    Near compared_source{}, compared_target{}, coherent_source{}, coherent_target{};
    double coherence = 0.0;  ///< λ_coh for one pair of neighbours
    double share = 0.0;      ///< of one pair of matches in the mean over pairs
  };
  double smaller_count() const;
  Neighbourhoods neighbourhoods() const;
  double own_coherence(const Neighbourhoods& around, std::size_t p, std::size_t q) const;
  static double shared_coherence(const Neighbourhoods& around, const MatchingAssignment& a,
                                 const MatchingAssignment& b);
  static bool are_compared(const Neighbourhoods& around, const MatchingAssignment& a,
                           const MatchingAssignment& b);
  void measure_descriptors();
  void set_costs(const Neighbourhoods& around, std::vector<MatchingAssignment>& assignments) const;
  double pair_cost(const Neighbourhoods& around, const MatchingAssignment& a,
                   const MatchingAssignment& b) const;
  void add_pairs(const Neighbourhoods& around, MatchingProblem& problem) const;
  std::vector<MatchingAssignment> assignments() const;
  Near nearest(const FeaturePlaces& places, int count) const;
  double coherence_weight(const Near& source, const Near& target) const;

  const FeaturePlaces& source_;
  const FeaturePlaces& target_;
  const FeatureMatchingOptions& options_;
  Eigen::MatrixXd descriptor_, source_twist_, target_twist_;
};

}  // namespace kinemesh
