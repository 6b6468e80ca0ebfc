// Principal components of an animated mesh: a mean shape, orthonormal modes, and how much of each
// every frame holds. Frame f is approximately mean + Σ_k scores(f, k) · modes(·, k).
//
// Exact (eigenvectors of the smaller Gram matrix in double) up to 800 frames or coordinates; above
// that by the randomised range finder with two power iterations (Halko, Martinsson & Tropp 2011,
// algorithms 4.4 and 5.1), which is as good as exact for motion, whose spectrum falls quickly.
#pragma once

#include <Eigen/Core>
#include <span>

#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"

namespace kinemesh {

struct PcaOptions {
  /// Most modes to find; 0: as many as the error asks for.
  int modes = 0;
  /// Stop at this root mean square distance between the vertices and their reconstruction.
  double rms_error_mm = 0.0;

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct PcaResult {
  Eigen::VectorXf mean;   ///< 3 × vertices (x, y, z of vertex 0 first), mm
  Eigen::MatrixXf modes;  ///< 3 × vertices rows, one orthonormal column per mode, strongest first;
                          ///< each has its largest component positive
  Eigen::MatrixXd scores;     ///< frames × modes, mm
  Eigen::VectorXd variances;  ///< per mode: mean over frames of its squared scores, mm²
  double total_variance = 0;  ///< mean over frames of the squared distance from the mean, mm²
  std::size_t vertex_count = 0;

  std::size_t mode_count() const { return static_cast<std::size_t>(modes.cols()); }
  /// Root mean square distance of vertices from the reconstruction by the first `mode_count`
  /// modes, in mm.
  double rms_error_mm(std::size_t mode_count) const;
  /// Share of the total variance that the first `mode_count` modes explain, in [0, 1]; 1 when
  /// nothing moves.
  double explained(std::size_t mode_count) const;
};

/// Throws InputError for a mesh without frames, UsageError for options out of range.
PcaResult pca_of(const AnimatedMesh& mesh, const PcaOptions& options = {},
                 const RunContext& ctx = {});

/// The coordinates of one frame from its scores (the first scores.size() modes), in mm.
Eigen::VectorXf reconstruct(const PcaResult& pca, std::span<const double> scores);

}  // namespace kinemesh
