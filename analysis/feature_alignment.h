// Temporal alignment of two animations by their features, and how alike they are (Mykhalchuk 2015,
// 7.2): the features of each in the order of their time, aligned with affine gap costs (Gotoh 1982,
// as the thesis' Gotoh 1990).
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/feature.h"
#include "config/parameter.h"

namespace kinemesh {

struct FeatureAlignmentOptions {
  double gap_open = 0.5;    ///< cost of the first feature of a run that has no counterpart
  double gap_extend = 0.3;  ///< of each further one
  double scale = 0.5;       ///< weight of |ln σ/σ′| (σ over the diagonal) and of |ln τ/τ′|
  double descriptor =
      1.0;            ///< weight of the difference of the deformation curves, if both have one
  double time = 0.0;  ///< weight of the difference of their times over the duration

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct FeatureAlignment {
  struct Pair {
    std::size_t a, b;  ///< indices into the features of the sets
    double cost;
  };
  std::vector<Pair> pairs;                  ///< in the order of time
  std::vector<std::size_t> only_a, only_b;  ///< without counterpart
  double pair_cost = 0.0, gap_cost = 0.0;
  /// 1 − (cost over that of leaving all features without counterpart): 1 for the same animation,
  /// 0 for animations that have nothing in common.
  double similarity = 0.0;
};

/// Features of kind deformation alone. Both sets without features are alike (1).
FeatureAlignment align_features(const FeatureSet& a, const FeatureSet& b,
                                const FeatureAlignmentOptions& options = {});

}  // namespace kinemesh
