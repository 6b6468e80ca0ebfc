// How far a map between two surfaces is from the truth: geodesic errors over √area of the target,
// as the benchmarks of correspondence report them (Kim, Lipman & Funkhouser 2011; Ren et al. 2018).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/landmarks.h"
#include "mesh/mesh.h"
#include "mesh/surface_point.h"

namespace kinemesh {

struct MapEvaluationOptions {
  int samples = 0;       ///< places of the truth that are measured, evenly spread; 0: all
  double cutoff = 0.25;  ///< of the curve and the area below it, in √area

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// Where source vertices truly lie on the target.
struct MapTruth {
  struct Place {
    VertexIndex source = 0;
    SurfacePoint target;
    SurfacePoint mirrored;  ///< invalid when not known
  };
  std::vector<Place> places;
  bool has_mirrored = false;
};
/// Throws InputError when the maps have not as many points.
MapTruth truth_from_map(const SurfaceMap& truth, const SurfaceMap* mirrored = nullptr);
/// Line k of each list is one place; `mirrored` may be empty. Throws InputError when the lists
/// differ in length, UsageError for a vertex without faces.
MapTruth truth_from_lists(const std::vector<VertexIndex>& source,
                          const std::vector<VertexIndex>& target,
                          const std::vector<VertexIndex>& mirrored, const Topology& topology);
/// Pairs whose source place is a vertex. Throws InputError for another.
MapTruth truth_from_pairs(const std::vector<LandmarkPair>& pairs, const Topology& source);

/// Errors over √area of the target.
struct MapErrors {
  std::vector<double> sorted;  ///< of the mapped places, ascending
  std::size_t unmapped = 0;    ///< they count as errors beyond any in the curve and the area
  double mean = 0.0, median = 0.0, p75 = 0.0, p90 = 0.0, p95 = 0.0, p99 = 0.0, worst = 0.0;
  double area_under_curve = 0.0;  ///< mean share of places within e, for e from 0 to the cutoff
  /// Share of the places whose error is at most `error`.
  double share_within(double error) const;
};

struct MapEvaluation {
  MapErrors errors;
  /// Against the mirror image of the truth as a whole, and at each place against the nearer of
  /// both. Set when the truth has one.
  std::optional<MapErrors> mirrored, either;
  /// Mean error of the least confident tenth over that of the most confident half; 0 when the map
  /// has no confidence or is exact.
  double confidence_ratio = 0.0;
  double root_area_mm = 0.0;
};

/// `target`: the mesh that the map leads to, in the pose in which errors are measured. Throws
/// InputError when map, truth and mesh do not fit, NoResultError when no place is mapped or the
/// mesh has no area.
MapEvaluation evaluate_map(const SurfaceMap& map, const MapTruth& truth, const Mesh& target,
                           const MapEvaluationOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
