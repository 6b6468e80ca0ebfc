// Which feature of one animation is which of another: graph matching of dynamic features
// (Mykhalchuk 2015, 5.5), on the solver of analysis/graph_matching.
//
//   const FeaturePlaces a = feature_places(set_a, animation_a), b = feature_places(set_b, …);
//   const FeatureMatching m = match_features(a, b);
//   m.matches[k].source, .target, .margin …
//
// Geodesic lengths are divided by √area and each descriptor distance by its mean over all pairs, so
// that the weights need no units. The energy is
//
//   λ_dscr mean θ_a + λ_geod mean θ_ab + λ_orient mean |twist difference| + λ_unmat E_unmat +
//   λ_coh E_coh,
//
// each mean over as many (pairs of) matches as the smaller set allows. The orientation term is
// ours: geodesics and descriptors are the same for a surface and its mirror image; the twist
// det(n_p, n_q, q − p) / |q − p| of two features and their normals changes its sign, and keeps left
// from being matched to right.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "analysis/feature.h"
#include "analysis/graph_matching/solve_matching.h"
#include "mesh/animated_mesh.h"

namespace kinemesh {

/// How the average-geodesic distance along the path between two features must agree (5.5.3).
enum class GeodesicPrior : uint8_t {
  none,
  printed,    ///< Algorithm 5-3: both increase or both decrease
  same_class  ///< both increase, both decrease, or neither does
};
enum class PathClass : uint8_t { level, increasing, decreasing, neither };

struct FeatureMatchingOptions {
  int candidates = 4;  ///< l of Algorithm 5-1; 0: every pair
  int neighbours = 0;  ///< k of the pairs of matches that are compared; 0: all pairs
  int coherence_neighbours = 4;
  double descriptor = 1.0;   ///< λ_dscr
  double geodesic = 4.0;     ///< λ_geod
  double orientation = 1.5;  ///< λ_orient
  double matched = 1.5;      ///< λ_unmat
  double coherence = 0.05;   ///< λ_coh
  double reject = 0.032;     ///< misfit above which a match is taken back, √area
  double time_weight = 1.0;  ///< of the difference in normalised time, beside the descriptors
  GeodesicPrior prior = GeodesicPrior::none;
  double prior_tolerance = 0.05;  ///< of the curve's range
  double max_pairs = 2e7;         ///< pairs of assignments at most
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// What matching needs of one animation. Features at the same vertex at different times stay apart.
struct FeaturePlaces {
  struct Place {
    Feature feature;
    uint32_t index = 0;                ///< in the feature set
    Eigen::Vector3d position, normal;  ///< in the rest pose; the normal of its surroundings
    double time = 0.0;                 ///< part of the duration
    std::vector<float> displacement, deformation;  ///< normalised curves
  };
  std::vector<Place> places{};
  Eigen::MatrixXd distances{};            ///< geodesic, in √area; infinite where no path leads
  std::vector<PathClass> path_classes{};  ///< places × places, row-major; empty without a prior
  double root_area_mm = 0.0;
};

/// Geodesics by the exact method on the first frame. Curves that the descriptors do not hold are
/// computed. Throws InputError when a feature lies on no vertex or frame of the animation,
/// NoResultError for a mesh without area.
FeaturePlaces feature_places(const FeatureSet& set, const AnimatedMesh& animation,
                             const FeatureMatchingOptions& options = {},
                             const RunContext& ctx = {});

/// The weighted terms of (5-6) of a labelling; their sum times the smaller count is its energy.
struct EnergyTerms {
  double descriptor = 0.0, geodesic = 0.0, orientation = 0.0, prior = 0.0, unmatched_part = 0.0,
         coherence = 0.0;
};

struct FeatureMatch {
  uint32_t source = 0, target = 0;  ///< indices into the feature sets
  double descriptor = 0.0;          ///< θ_a
  double geodesic = 0.0;            ///< mean relative distortion to the other matches
  double orientation = 0.0;         ///< mean twist difference to the other matches
  double distance_change = 0.0;     ///< mean change of distances and twists to near others, √area
  double offset = 0.0;              ///< from where a smooth map through the others puts it, √area
  double misfit = 0.0;              ///< of both, what is compared with the option `reject`
  double energy = 0.0;              ///< what the match adds to the energy, × the smaller count
  uint32_t runner_up = unmatched;   ///< the target feature that would be next best; or none
  double margin = 0.0;  ///< by how much the energy (× the smaller count) is worse with it
};

struct FeatureMatching {
  std::vector<FeatureMatch> matches;  ///< by ascending source
  std::vector<uint32_t> unmatched_source, unmatched_target;
  std::vector<FeatureMatch> rejected;  ///< taken back for their distortion
  MatchingResult solution;             ///< energy and bound of the graph matching
  std::size_t assignments = 0, pairs = 0;
  EnergyTerms terms;         ///< of the solution, before matches are taken back
  std::string empty_reason;  ///< why there are no matches
};

/// Throws NoResultError, as match_features() would, when so many features cannot be compared: to
/// ask before their geodesics are measured.
void refuse_too_many_features(std::size_t source, std::size_t target,
                              const FeatureMatchingOptions& options);

/// Throws NoResultError, which names the memory and the remedy, when there are more pairs of
/// assignments than options.max_pairs.
FeatureMatching match_features(const FeaturePlaces& source, const FeaturePlaces& target,
                               const FeatureMatchingOptions& options = {},
                               const MatchingOptions& solver = {}, const RunContext& ctx = {});

}  // namespace kinemesh
