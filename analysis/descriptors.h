// What the surroundings of a feature look like in motion (Mykhalchuk 2015, 5.3), and how different
// two features are. Each part is usable alone.
//
// AnimMeshHoG (5.3.4): the patch within `patch` σ of the feature whose normals lie within 90° of
// its own is flattened by isomap (landmark MDS; de Silva & Tenenbaum 2003) and turned so that the
// dominant gradient of deformation points along x; with the frames within `patch` τ it is a volume,
// scaled to [−1, 1]³, into which deformation is interpolated by Gaussian radial basis functions on
// a regular grid. Gradients are counted by octant and by direction (8 azimuths × 4 elevations),
// each bin over its solid angle, and smoothed (Eilers & Goeman 2004). Where the animation's end
// clips the volume, octants without samples stay empty and take no part in a comparison.
#pragma once

#include <array>
#include <span>

#include "analysis/anim_dog.h"
#include "analysis/feature.h"

namespace kinemesh {

struct DescriptorOptions {
  bool curves = true;     ///< displacement and deformation curves
  bool histogram = true;  ///< AnimMeshHoG, of deformation features
  double patch = 3.0;     ///< radius of the volume in σ and τ
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// Fills in the descriptors of all features of the set, which must be of this animation.
void describe_features(FeatureSet& set, const AnimatedMesh& animation,
                       const DeformationResult& deformation, const DescriptorOptions& options = {},
                       const RunContext& ctx = {});

/// Weights of the parts in the composite distance (5.3.5). The distances of curves are of
/// normalised values, that of histograms is in radians: the weights make them count about alike.
struct DescriptorWeights {
  double displacement = 6.0, deformation = 8.0, histogram = 1.0;
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// Root mean square difference of two curves over their whole lengths, as natural cubic splines of
/// normalised time sampled at 64 instants, so that frame counts may differ (5-2, 5-3; the thesis'
/// sum of squares, made independent of the number of samples). 0 when either is empty.
double curve_distance(std::span<const float> a, std::span<const float> b);

/// Mean over the octants that both have of the earth mover's distance of their directions, in
/// radians (5-4, 5-5; the ground distance is the angle between the middles of the bins). 0 when
/// either is empty.
double histogram_distance(std::span<const float> a, std::span<const float> b);

/// Weighted sum of what both descriptors have; of the displacement curve alone when either feature
/// is a displacement feature (5.4).
double descriptor_distance(const Feature& a, const Feature& b,
                           const DescriptorWeights& weights = {});

}  // namespace kinemesh
