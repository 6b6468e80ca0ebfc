// A performance by curves: the principal shapes of one or several animations of the same mesh, and
// the scores of any other animation in them.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/pca/pca.h"

namespace kinemesh {

/// Frame = mean + modes · scores, in mm; see PcaResult. `pca.scores` has the frames of all
/// animations it was made of, one after the other.
struct ExpressionBasis {
  std::shared_ptr<const Topology> topology;
  PcaResult pca;
  std::vector<std::string> sources;       ///< what it was made of
  std::vector<std::size_t> frame_counts;  ///< frames of each
};

/// Throws InputError when there is no animation, or they differ in topology.
ExpressionBasis make_expression_basis(const std::vector<AnimatedMesh>& animations,
                                      const PcaOptions& options = {}, const RunContext& ctx = {});

/// The scores of an animation in a basis.
struct ExpressionScores {
  Eigen::MatrixXd scores;        ///< frames × modes, mm
  Eigen::VectorXd rms_error_mm;  ///< per frame: of the vertices from mean + modes · scores
  double explained = 0.0;        ///< share of its motion about the basis' mean, in [0, 1]
};

/// Throws InputError when the animation has another topology than the basis.
ExpressionScores express(const ExpressionBasis& basis, const AnimatedMesh& animation,
                         const RunContext& ctx = {});

/// The animation again, on the basis' mesh.
AnimatedMesh animation_from(const ExpressionBasis& basis, const Eigen::MatrixXd& scores,
                            double rate_hz);

/// NumPy archive: mean (vertices × 3), modes (modes × vertices × 3), variances, explained (shares
/// up to each mode), rms_error_mm (with so many modes), total_variance, scores (frames × modes),
/// sources, frame_counts, faces (0-based). Written whole or not at all.
void write_expression_basis(const std::filesystem::path& path, const ExpressionBasis& basis);
/// Throws InputError naming the array for whatever does not belong together.
ExpressionBasis read_expression_basis(const std::filesystem::path& path);

/// `frame,time_s,rms_error_mm,mode_1,…`, one line a frame; frame numbers of the take.
std::string scores_csv(const ExpressionScores& scores, double rate_hz, int64_t first_frame);

}  // namespace kinemesh
