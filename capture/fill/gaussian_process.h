// Gaussian process regression of one gap on the other markers and time, with a calibrated
// uncertainty.
//
// Covariance of two frames with inputs x, x′ (training_set.h) and times t, t′, up to a scale that
// the data give (yᵀK⁻¹y): linear x·x′ + a rational quadratic of |x − x′| + Matérn 7/2 of |t − t′| +
// a constant; see Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 2, 4
// and 5. The time term makes the estimate join the measured samples at both ends.
#pragma once

#include <vector>

#include "capture/fill/training_set.h"

namespace kinemesh::fill {

struct ProcessOptions {
  double linear = 200.0;  ///< amplitudes; only their relations matter, the time term's is 1
  double quadratic = 10.0;
  double constant = 1.0;
  double time_over_gap_s = 10.0;  ///< the time term's: this over the length of the gap, 8 to 40,
                                  ///< for the shorter a gap, the more the marker's own motion tells
  std::vector<double> lengths = {0.125, 0.25, 0.5};  ///< of the rational quadratic, in units of the
                                                     ///< root mean square norm of the inputs
  std::vector<double> times_s = {5.0 / 60.0, 10.0 / 60.0};  ///< of the Matérn term
  std::size_t noise_rows = 120;            ///< at most so many rows tell noise from motion
  double noise_step = 3.1622776601683795;  ///< factor from one noise tried to the next
  double widening = 1.0;                   ///< of the band: few rows know their own errors badly
  double softening = 10.0;  ///< settings are averaged by (marginal likelihood)^(softening / values)
};

/// `noise_variance`: of one measured coordinate, mm²; it is left out of the uncertainty, which is
/// that of the true position. `rate_hz`: frames per second.
Estimate estimate_gap(const TrainingSet& set, double rate_hz, double noise_variance,
                      const ProcessOptions& options = {});

/// Variance of the independent noise on one coordinate of a marker, mm², from the median size of
/// the fourth differences of its measured samples (motion is nearly free of them).
double noise_variance(const Trajectories& take, std::size_t marker);

}  // namespace kinemesh::fill
