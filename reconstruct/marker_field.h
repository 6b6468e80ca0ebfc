// What the markers say together, before their displacements are spread over a scan: measurement
// noise that no neighbour shares is taken off, and a marker with a gap gives way softly to what its
// neighbours predict.
//
// Each frame's displacements are a Gaussian field with the covariance of the drive operator, scaled
// by how much the face moves around each marker in that frame, plus noise (kriging; Rasmussen &
// Williams 2006, eq. 2.23): where the face is still it stays still, and where it moves it moves
// fully. The noise is that of most likelihood over the take. No measured marker is moved by more
// than 2.5 times the noise: what lies beyond is no noise but motion that the prior does not know.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "config/run_context.h"

namespace kinemesh {

struct MarkerFieldOptions {
  bool smooth = true;     ///< false: measured markers are taken as they are
  double noise_mm = 0.0;  ///< of each coordinate; 0: estimated
};

struct MarkerFieldResult {
  Eigen::MatrixXf displacements;   ///< markers × (3 × frames), mm
  double noise_mm = 0.0;           ///< given or estimated; 0 without smoothing
  double largest_change_mm = 0.0;  ///< of a measured marker, by smoothing
};

/// `displacements`: markers × (3 × frames), finite, mm; `absence`: markers × frames, 0 where the
/// marker counts fully, 1 where it does not at all, and between.
MarkerFieldResult settle_markers(const Eigen::MatrixXd& displacements,
                                 const Eigen::MatrixXf& absence, const Eigen::MatrixXd& covariance,
                                 const MarkerFieldOptions& options = {},
                                 const RunContext& ctx = {});

/// How absent each sample is: 0 where measured, rising smoothly over `fade_s` to 1 inside gaps.
/// `measured`: markers × frames, 1 or 0. Short gaps stay well below 1.
Eigen::MatrixXf absence_of(const Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic>& measured,
                           double rate_hz, double fade_s);

}  // namespace kinemesh
