// AniM-DoG: features of an animated mesh as extrema of a spatio-temporal difference of Gaussians of
// its deformation (Mykhalchuk 2015, 4.5–4.8).
//
//   const DeformationResult d = deformation_of(animation);
//   const DetectResult found = detect_features(animation, d);
//
// L(k, l) is the deformation smoothed to the spatial scale σ_k and the temporal scale τ_l, and
//   D(k, l) = a (L(k+1, l) − L(k, l)) + b (L(k, l+1) − L(k, l));
// a feature is a strict minimum of D over its neighbours in space and time and the eight
// neighbouring scales. Space and time filters commute: the spatial ones run once over all frames,
// and all that follows is local to a vertex, whose levels fit into the cache. docs/analysis.md
// gives the measurements behind the defaults.
#pragma once

#include "analysis/deformation.h"
#include "analysis/feature.h"

namespace kinemesh {

enum class SpatialFilter : uint8_t {
  ring,      ///< the mean over a vertex and its neighbours: the thesis
  cotangent  ///< diffusion by the cotangent Laplacian, a Gaussian whatever the triangulation
};
enum class ScaleNorm : uint8_t {
  thesis,   ///< a = σ² √τ, b = σ √τ³; σ in mean edges, τ in frames
  variance  ///< both divided by the step of variance between the levels
};

struct DetectOptions {
  SpatialFilter filter = SpatialFilter::cotangent;
  ScaleNorm norm = ScaleNorm::variance;
  /// Levels of D in space, and the first σ in √area of the rest pose (cotangent); each next σ is
  /// `step` times the one before.
  int sigma_levels = 5;
  double sigma = 0.02;
  /// Levels of D in time, and the first τ as a part of the duration.
  int tau_levels = 5;
  double tau = 0.02;
  double step = 1.4142135623730951;
  /// With the ring filter: averagings in space and in time, each a level; 0 takes as many as find
  /// the largest blob that the data can hold (4-12).
  int smoothings = 0;
  int time_smoothings = 54;
  bool end_scales = true;  ///< minima at the first and last scale count, too
  /// Weaker features this near to a stronger one in space (part of the diagonal) and in time (part
  /// of the duration) are left out; 0 keeps them.
  double apart = 0.05;
  double apart_time = 0.05;
  double threshold = 0.02;    ///< least response, as a part of the strongest
  int strongest = 30;         ///< as many features at most; 0: all
  double memory_mb = 1000.0;  ///< for the scale space; what does not fit is done in tiles

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// The settings that the thesis prints: λ₁ + 7 |κ − κ₁| × edge, 1-ring averages, a level for every
/// smoothing, thresholds, all features.
void set_thesis_preset(DeformationOptions& deformation, DetectOptions& detect);

struct DetectResult {
  FeatureSet set;
  std::vector<double> sigmas_mm;  ///< of the spatial levels (mean over the mesh)
  std::vector<double> taus_s;     ///< of the temporal levels; in frames when the rate is unknown
  std::size_t samples = 0;        ///< vertices × frames × levels that were tested
  std::size_t extrema = 0;        ///< strict minima, before threshold, distance and number
  std::size_t tiles = 0;
  std::size_t level_bytes = 0;  ///< largest memory of the scale space at any time
  double spatial_passes = 0;    ///< smoothings over all vertices and frames
  std::string empty_reason;     ///< why there are no features; empty when there are
};

/// Throws UsageError when `deformation` is not of this animation's size.
DetectResult detect_features(const AnimatedMesh& animation, const DeformationResult& deformation,
                             const DetectOptions& options = {}, const RunContext& ctx = {});

/// As above for any scalar (MeshDoG's comparison, tests with closed forms).
DetectResult detect_in_scalar(const AnimatedMesh& animation, const DeformationResult& rest,
                              const VertexCurves& scalar, const DetectOptions& options = {},
                              const RunContext& ctx = {});

struct DisplacementOptions {
  double least_path = 0.1;   ///< of the longest path of any vertex
  double path_apart = 0.05;  ///< of the diagonal: within it only the longest path counts
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// Local maxima of the length of the vertices' paths (5.4), longest first; `frame` is that of the
/// largest step, `response` the length over the longest.
std::vector<Feature> displacement_features(const AnimatedMesh& animation,
                                           const DeformationResult& rest,
                                           const DisplacementOptions& options = {});

}  // namespace kinemesh
