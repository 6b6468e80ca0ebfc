// How well the features of two animations agree where the true map between them is known.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "analysis/feature.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/mesh.h"
#include "mesh/surface_point.h"

namespace kinemesh {

struct ConsistencyOptions {
  double near = 0.05;       ///< tolerance in space, of the target's diagonal
  double near_time = 0.05;  ///< tolerance in time, of the duration
  int count = 20;           ///< the strongest features of each are compared; 0: all
  int slack = 30;           ///< … with so many of the other's, in the measure with slack
  int trials = 20;          ///< random draws behind the levels by chance
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// Shares in [0, 1].
struct Consistency {
  double strict = 0;   ///< pairs one to one within both tolerances, over the larger count
  double slack = 0;    ///< as strict, the strongest of each into more of the other's; mean of both
  double nearest = 0;  ///< 4.9.1: features whose nearest one lies within `near`, whatever its time
};

struct ConsistencyResult {
  Consistency features;
  Consistency random;    ///< as many random vertices and frames
  Consistency shuffled;  ///< the same places, their times exchanged among each other
  std::size_t source_count = 0, target_count = 0;
  std::size_t unmapped = 0;  ///< source features whose vertex the map leaves out
  /// Distances of 4.9.1 over the target's diagonal, both directions, ascending: the curve of
  /// figure 4-18.
  std::vector<double> errors, random_errors;
};

/// `truth` maps the vertices of the source mesh to `target` (its rest shape). Times are compared as
/// parts of each animation's duration. Throws InputError when map, features and mesh do not fit.
ConsistencyResult feature_consistency(const FeatureSet& source, const FeatureSet& target,
                                      const SurfaceMap& truth, const Mesh& target_mesh,
                                      const ConsistencyOptions& options = {},
                                      const RunContext& ctx = {});

/// One detected region against regions marked by hand (4.9.2): precision and recall where more
/// than a share of the volunteers marked a vertex.
struct RegionScore {
  double threshold;  ///< share of volunteers
  double precision;  ///< of the vertices within σ of a feature, those marked (by area)
  double recall;     ///< of the marked vertices, those within σ of a feature (by area)
};

/// `marked`: share of the volunteers in [0, 1] who marked each vertex. A feature's region are the
/// vertices within its σ along the surface. Throws InputError when sizes differ.
std::vector<RegionScore> compare_regions(const FeatureSet& features, const Mesh& mesh,
                                         std::span<const double> marked,
                                         std::span<const double> thresholds);

/// Per vertex the number of features whose region holds it; those without a σ (of displacement)
/// have none.
std::vector<double> feature_coverage(const FeatureSet& features, const Mesh& mesh);

}  // namespace kinemesh
