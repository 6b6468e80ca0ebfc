// Pictures of features: spheres on the deforming surface (Mykhalchuk 2015, figure 4-16).
#pragma once

#include <string>

#include "analysis/deformation.h"
#include "analysis/feature.h"
#include "report/canvas.h"

namespace kinemesh {

struct FeatureViewOptions {
  std::string title = "Features";
  int frames = 6;  ///< of the strip
};

/// Above, all features on the rest pose from two sides; below, a strip of the frames in which the
/// strongest lie, coloured by deformation, with the features of that moment (within τ). A sphere's
/// radius is σ, its colour 1/τ (red: fast); displacement features are small and dark. Drawn without
/// a display.
Canvas draw_features(const AnimatedMesh& animation, const DeformationResult& deformation,
                     const FeatureSet& set, const FeatureViewOptions& options = {},
                     const RunContext& ctx = {});

/// One frame for a video: the deforming surface with the features of that moment.
Image draw_feature_frame(const AnimatedMesh& animation, const DeformationResult& deformation,
                         const FeatureSet& set, std::size_t frame, const RunContext& ctx = {});

}  // namespace kinemesh
