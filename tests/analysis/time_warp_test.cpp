// Alignment in time against warps that are known.
#include "analysis/time_warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "config/error.h"
#include "tests/support/data.h"
#include "tests/support/ict_performer.h"
#include "tests/support/sanitizers.h"

namespace kinemesh::time_warp_test {
namespace {

double bump(double t, double centre, double width) {
  return std::exp(-std::pow((t - centre) / width, 2));
}

/// Three channels, as of parts of the surface that move at different times.
double motion(double t, std::size_t channel) {
  switch (channel) {
    case 0: return bump(t, 0.8, 0.2) + 0.6 * bump(t, 2.2, 0.3);
    case 1: return 0.7 * bump(t, 0.9, 0.15) + 0.2 * bump(t, 1.6, 0.2);
    default: return 0.4 * bump(t, 1.5, 0.4);
  }
}

MotionCurves curves(double duration_s, double rate_hz, const std::function<double(double)>& time,
                    double amplitude = 1.0) {
  MotionCurves result(static_cast<std::size_t>(std::lround(duration_s * rate_hz)) + 1, 3, rate_hz);
  for (std::size_t f = 0; f < result.frame_count; ++f) {
    for (std::size_t c = 0; c < 3; ++c) {
      result.at(f, c) = amplitude * motion(time(static_cast<double>(f) / rate_hz), c);
    }
  }
  return result;
}

double same(double t) { return t; }

/// Largest error of the warp where something moves, s.
double error_of(const TimeWarpResult& result, const std::function<double(double)>& b_of_a) {
  double worst = 0.0;
  for (std::size_t f = 0; f < result.b_of_a_s.size(); ++f) {
    if (result.determined[f] == 0) continue;
    const double a = static_cast<double>(f) / result.rate_hz;
    worst = std::max(worst, std::abs(result.b_of_a_s[f] - b_of_a(a)));
  }
  return worst;
}

TEST(TimeWarp, APerformanceIsAlignedWithItselfExactly) {
  const MotionCurves a = curves(3, 60, same);
  const TimeWarpResult result = align_in_time(a, a);
  EXPECT_LT(error_of(result, same), 1e-9);
  EXPECT_EQ(result.delay_s, 0.0);
  EXPECT_LT(result.difference, 1e-9);
  EXPECT_DOUBLE_EQ(result.amplitude, 1.0);
}

TEST(TimeWarp, AKnownWarpIsFoundWithinAFrame) {
  // B does at w what A does at time_in_a(w); its inverse is found by bisection.
  const auto time_in_a = [](double w) { return w * 3.0 / 3.6 + 0.15 * std::sin(w * M_PI / 1.8); };
  const auto b_of_a = [&](double t) {
    double low = 0, high = 3.6;
    for (int i = 0; i < 60; ++i) (time_in_a((low + high) / 2) < t ? low : high) = (low + high) / 2;
    return low;
  };
  const MotionCurves a = curves(3, 60, same);
  for (const double rate : {60.0, 100.0}) {
    const TimeWarpResult result = align_in_time(a, curves(3.6, rate, time_in_a));
    EXPECT_LT(error_of(result, b_of_a), 1.0 / 100.0) << rate;
    EXPECT_LT(result.difference, 0.02);
    EXPECT_GT(result.difference_unwarped, 5 * result.difference);
    EXPECT_TRUE(std::ranges::is_sorted(result.b_of_a_s));
  }
}

TEST(TimeWarp, ADelayOfHalfASecondAtHalfTheAmplitude) {
  const TimeWarpResult result =
      align_in_time(curves(3, 60, same), curves(
                                             3.5, 60, [](double t) { return t - 0.5; }, 0.5));
  EXPECT_LT(error_of(result, [](double t) { return t + 0.5; }), 1.0 / 60.0);
  EXPECT_NEAR(result.delay_s, 0.5, 0.005);
  EXPECT_NEAR(result.amplitude, 0.5, 0.01);
}

TEST(TimeWarp, NoiseMovesItLittle) {
  MotionCurves a = curves(3, 60, same), b = curves(3, 60, [](double t) { return t - 0.2; });
  uint64_t state = 7;
  for (MotionCurves* c : {&a, &b}) {
    for (double& v : c->values) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      v += 0.02 * (static_cast<double>(state >> 40U) / 16777216.0 - 0.5);
    }
  }
  const TimeWarpResult result = align_in_time(a, b, {.still = 0.2});
  EXPECT_LT(error_of(result, [](double t) { return t + 0.2; }), 2.0 / 60.0);
}

TEST(TimeWarp, TwoFacesAreAlignedByWhatTheirSurfacesDo) {
  KINEMESH_LEAVE_TO_RELEASE("Comparison.OnsetAndPeakOfTheSamples");
  KINEMESH_NEED_DATA("face_ict");
  const auto model = test::load_ict(test::data_folder() / "face_ict");
  const test::IctMotion motion = test::make_ict_motion(*model, 1);
  const test::IctActor a(*model, {.seed = 1}, motion);
  const test::IctActor b(*model, {.seed = 7}, motion,
                         {.turn_degrees = 20, .scale = 0.2, .delay_s = 0.3});
  const auto signature = [](const test::IctActor& actor, double rate_hz) {
    const AnimatedMesh mesh = test::perform(actor, {.rate_hz = rate_hz}).mesh;
    return motion_signature(mesh, deformation_of(mesh));
  };
  const TimeWarpResult result = align_in_time(signature(a, 30), signature(b, 45));
  EXPECT_NEAR(result.delay_s, b.delay_s(), 1.0 / 30.0);
  EXPECT_LT(result.difference, 0.15);
}

TEST(TimeWarp, BadInputIsRefused) {
  const MotionCurves a = curves(3, 60, same);
  EXPECT_THROW(align_in_time(a, MotionCurves(50, 2, 60)), UsageError);
  EXPECT_THROW(align_in_time(a, MotionCurves(50, 3, 0)), UsageError);
  EXPECT_THROW(align_in_time(a, MotionCurves(1, 3, 60)), NoResultError);
  EXPECT_THROW(align_in_time(a, MotionCurves(50, 3, 60)), NoResultError);  // nothing moves
}

}  // namespace
}  // namespace kinemesh::time_warp_test
