// When a movement begins, is complete and is over, from one curve over time.
//
// Movements start and end smoothly, so that a threshold is late by an amount that depends on it.
// Instead the rise between 5 and 60 % is read as that of a minimum-jerk movement (Flash & Hogan
// 1985): through its inverse the rise becomes a straight line in time, which is followed back to
// where it is 0.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace kinemesh {

struct MovementTiming {
  double onset_s = 0.0;   ///< the movement begins
  double peak_s = 0.0;    ///< its level is reached
  double offset_s = 0.0;  ///< it is over; the end of the curve when it does not come back
  bool comes_back = false;
  double level = 0.0;  ///< what is reached: the mean while it is held
};

/// Of the strongest movement away from the curve's value at rest, in either direction. `rest` is
/// that value, `noise` the curve's standard deviation at rest. Nothing when no movement stands out
/// from the noise (by ten times) or the curve has fewer than eight samples.
std::optional<MovementTiming> movement_timing(std::span<const double> curve, double rate_hz,
                                              double rest, double noise);

/// Of the movement that holds its level 1 at frame `at`, from a rest of 0; nothing when it does not
/// begin within the curve.
std::optional<MovementTiming> timing_around(std::span<const double> curve, double rate_hz,
                                            std::size_t at);

/// Largest speed of a curve, per second, smoothed by a Gaussian of `smoothing_s`.
double peak_speed(std::span<const double> curve, double rate_hz, double smoothing_s);

}  // namespace kinemesh
