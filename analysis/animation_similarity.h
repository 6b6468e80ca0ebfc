// How alike two animations are in what happens and when (Mykhalchuk 2015, 7.2).
#pragma once

#include "analysis/feature_alignment.h"
#include "analysis/time_warp.h"

namespace kinemesh {

/// Each part from 0 (nothing in common) to 1 (the same).
struct AnimationSimilarity {
  double features = 0.0;  ///< the features in their order: FeatureAlignment::similarity
  double curves = 0.0;    ///< how much deforms at corresponding times, amplitude aside
  double timing = 0.0;    ///< how little time had to be bent where something moves, delay aside
  double overall = 0.0;   ///< mean of the three
};

AnimationSimilarity similarity_of(const FeatureAlignment& features, const TimeWarpResult& warp);

}  // namespace kinemesh
