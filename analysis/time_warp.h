// Which instant of one performance corresponds to which of another.
//
// Dynamic time warping (Sakoe & Chiba 1978) of the curves and their derivatives finds the way; it
// steps from frame to frame, so that it is then made smooth and sub-frame by least squares
// (Gauss–Newton) on the curves as splines. Performances may differ in length, frame rate and
// amplitude. Where nothing moves, time is not determined, and the warp only goes on.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/motion_curves.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

struct TimeWarpOptions {
  /// Changes of the warp's speed within this time are smoothed out; the curves themselves by a
  /// Gaussian of half of it.
  double smoothing_s = 0.05;
  double step_cost = 0.01;   ///< of time going on in one performance alone, for each frame
  double still = 0.05;       ///< slower than this part of the fastest change: nothing moves
  int coarse_frames = 2000;  ///< longer performances are warped at a lower rate first

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct TimeWarpResult {
  double rate_hz = 0.0;              ///< of A
  std::vector<double> b_of_a_s;      ///< per frame of A the instant of B in s, not descending
  std::vector<uint8_t> determined;   ///< per frame of A: 1 where something moves
  double amplitude = 1.0;            ///< of B's curves over A's
  double difference = 0.0;           ///< RMS of B's curves, brought to A's time and amplitude,
                                     ///< less A's, over the RMS of A's: 0 is equal
  double difference_unwarped = 0.0;  ///< the same with both simply stretched to one duration
  double delay_s = 0.0;              ///< median of b − a where something moves

  /// The instant of B at `a_s`; before the first and after the last frame it goes on at speed 1.
  double at(double a_s) const;
};

/// Curves of both with the same channels. Throws UsageError when channels differ or a rate is
/// unknown, NoResultError when nothing moves in one of them.
TimeWarpResult align_in_time(const MotionCurves& a, const MotionCurves& b,
                             const TimeWarpOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
