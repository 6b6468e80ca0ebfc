#include "analysis/comparison/movement_timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace kinemesh::movement_timing_test {
namespace {

double minimum_jerk(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10 + x * (6 * x - 15));
}

/// 10 mm up and down again, from a rest of 30 mm.
std::vector<double> pulse(double onset, double peak, double release, double end, double rate,
                          double noise, double size = 10.0) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, noise > 0 ? noise : 1.0);
  std::vector<double> curve;
  for (int f = 0; f < 4.0 * rate; ++f) {
    const double t = f / rate;
    curve.push_back(30.0 + (noise > 0 ? normal(random) : 0.0) +
                    size * (minimum_jerk((t - onset) / (peak - onset)) -
                            minimum_jerk((t - release) / (end - release))));
  }
  return curve;
}

TEST(MovementTiming, FindsOnsetPeakAndOffsetOfASmoothMovementWithinAFrame) {
  for (const double rate : {60.0, 120.0, 250.0}) {
    for (const double size : {10.0, -4.0}) {
      const auto curve = pulse(0.83, 1.41, 2.2, 3.05, rate, 0.0, size);
      const auto timing = movement_timing(curve, rate, 30.0, 0.01);
      ASSERT_TRUE(timing);
      EXPECT_NEAR(timing->onset_s, 0.83, 1.0 / rate);
      EXPECT_NEAR(timing->peak_s, 1.41, 1.0 / rate);
      EXPECT_NEAR(timing->offset_s, 3.05, 1.0 / rate);
      EXPECT_TRUE(timing->comes_back);
      EXPECT_NEAR(timing->level, 30.0 + size, 0.1);
    }
  }
}

TEST(MovementTiming, WithstandsNoise) {
  const auto timing = movement_timing(pulse(0.83, 1.41, 2.2, 3.05, 120, 0.05), 120, 30.0, 0.05);
  ASSERT_TRUE(timing);
  EXPECT_NEAR(timing->onset_s, 0.83, 2.0 / 120);
  EXPECT_NEAR(timing->peak_s, 1.41, 2.0 / 120);
}

TEST(MovementTiming, AMovementWithoutAPlateauPeaksWhereItIsHighest) {
  std::vector<double> curve;
  for (int f = 0; f < 400; ++f) {
    const double t = f / 100.0;
    curve.push_back(t > 1 && t < 3 ? 5.0 * (1 - std::cos((t - 1) * M_PI)) / 2 : 0.0);
  }
  const auto timing = movement_timing(curve, 100, 0.0, 0.001);
  ASSERT_TRUE(timing);
  EXPECT_NEAR(timing->onset_s, 1.0, 0.1);
  EXPECT_NEAR(timing->peak_s, 2.0, 0.15);
}

TEST(MovementTiming, WhatDoesNotEndSaysSo) {
  const auto timing = movement_timing(pulse(0.8, 1.4, 9, 10, 100, 0.0), 100, 30.0, 0.01);
  ASSERT_TRUE(timing);
  EXPECT_FALSE(timing->comes_back);
  EXPECT_NEAR(timing->peak_s, 1.4, 0.01);
}

TEST(MovementTiming, NothingMovesInNoise) {
  EXPECT_FALSE(movement_timing(pulse(5, 6, 7, 8, 100, 0.1), 100, 30.0, 0.1));
  EXPECT_FALSE(movement_timing(std::vector<double>(100, 3.0), 100, 3.0, 0.0));
  EXPECT_FALSE(movement_timing(std::vector<double>{1, 2, 3}, 100, 0.0, 0.0));
  EXPECT_FALSE(movement_timing(pulse(1, 2, 3, 4, 100, 0.0), 0.0, 30.0, 0.0));
}

TEST(MovementTiming, PeakSpeedIsThatOfMinimumJerk) {
  // 15/8 of the mean speed.
  EXPECT_NEAR(peak_speed(pulse(0.5, 1.5, 2, 3.9, 200, 0.0), 200, 0.005), 10.0 * 15 / 8, 0.1);
  EXPECT_EQ(peak_speed(std::vector<double>{1}, 100, 0.02), 0.0);
}

}  // namespace
}  // namespace kinemesh::movement_timing_test
