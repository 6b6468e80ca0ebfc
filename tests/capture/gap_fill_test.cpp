#include "capture/gap_fill.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <random>

#include "capture/fill/spline.h"
#include "config/error.h"

namespace kinemesh::gap_fill_test {
namespace {

constexpr double pi = 3.14159265358979323846;

/// A face-like cloud: markers on a curved sheet 25 mm apart, moved by three smooth modes.
Eigen::Vector3d truth(std::size_t marker, std::size_t frame) {
  const double x = 25.0 * static_cast<double>(marker % 5) - 50.0;
  const double y = 25.0 * static_cast<double>(marker / 5) - 40.0;
  const double t = static_cast<double>(frame) / 60.0;
  const double smile = 4.0 * std::sin(2.0 * pi * 0.43 * t);
  const double brow = 3.0 * std::sin(2.0 * pi * 0.71 * t + 1.0);
  const double jaw = 5.0 * std::sin(2.0 * pi * 0.29 * t + 2.0);
  return {x + smile * x / 50.0,
          y + brow * std::exp(-(y - 40.0) * (y - 40.0) / 2000.0) -
              jaw * std::exp(-(y + 40.0) * (y + 40.0) / 2000.0),
          700.0 - x * x / 100.0 - y * y / 150.0 + 0.5 * smile};
}

MarkerSequence face(std::size_t frames, std::size_t markers) {
  std::vector<Marker> names(markers);
  for (std::size_t m = 0; m < markers; ++m) names[m].label = "m" + std::to_string(m);
  MarkerSequence take(frames, names, 60.0);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < markers; ++m) {
      take.position(f, m) = truth(m, f).cast<float>();
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
      take.residuals()[take.sample(f, m)] = 0.1F;
      take.camera_masks()[take.sample(f, m)] = 3;
    }
  }
  return take;
}

void remove(MarkerSequence& take, std::size_t marker, FrameRange frames) {
  for (std::size_t f = frames.begin; f < frames.end; ++f) {
    take.flags()[take.sample(f, marker)] = 0;
    take.position(f, marker).setConstant(std::numeric_limits<float>::quiet_NaN());
  }
}

double rms_error(const MarkerSequence& take, std::size_t marker, FrameRange frames) {
  double squares = 0.0;
  for (std::size_t f = frames.begin; f < frames.end; ++f) {
    squares += (take.position(f, marker).cast<double>() - truth(marker, f)).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(frames.size()));
}

void expect_whole(const MarkerSequence& before, const MarkerSequence& after) {
  for (std::size_t f = 0; f < after.frame_count(); ++f) {
    for (std::size_t m = 0; m < after.marker_count(); ++m) {
      ASSERT_TRUE(after.valid(f, m)) << f << " " << m;
      ASSERT_TRUE(after.position(f, m).allFinite()) << f << " " << m;
      ASSERT_NE(after.position(f, m).norm(), 0.0F);
      if (before.valid(f, m)) {
        ASSERT_EQ(before.position(f, m), after.position(f, m));
        ASSERT_FALSE(after.filled(f, m));
        continue;
      }
      ASSERT_TRUE(after.filled(f, m));
      const float sd = after.uncertainty()[after.sample(f, m)];
      ASSERT_TRUE(std::isfinite(sd));
      ASSERT_GE(sd, 0.0F);
    }
  }
}

TEST(GapFill, ATakeWithoutGapsStaysAsItIs) {
  const MarkerSequence take = face(10, 4);
  const auto result = fill_gaps(take);
  EXPECT_TRUE(result.fills.empty());
  EXPECT_TRUE(result.take.uncertainty().empty());
  EXPECT_TRUE(std::ranges::equal(result.take.positions(), take.positions()));
}

TEST(GapFill, FillsGapsInTheMiddleAndAtBothEndsByDefault) {
  MarkerSequence take = face(300, 20);
  const MarkerSequence complete = take;
  remove(take, 7, {100, 160});
  remove(take, 3, {0, 12});
  remove(take, 12, {280, 300});
  remove(take, 8, {140, 143});
  const auto result = fill_gaps(take);
  expect_whole(take, result.take);
  ASSERT_EQ(result.fills.size(), 4U);
  EXPECT_EQ(result.fills[1].marker, 7U);
  EXPECT_EQ(result.fills[1].frames, (FrameRange{100, 160}));
  EXPECT_GT(result.fills[1].mean_sd_mm, 0.0);
  EXPECT_LT(rms_error(result.take, 7, {100, 160}), 0.8);
  EXPECT_LT(rms_error(result.take, 3, {0, 12}), 0.8);
  EXPECT_LT(rms_error(result.take, 12, {280, 300}), 0.8);
  EXPECT_LT(rms_error(result.take, 8, {140, 143}), 0.02);
}

TEST(GapFill, LeavesNothingOpenWhenNoOtherMarkerIsComplete) {
  MarkerSequence take = face(200, 12);
  for (std::size_t m = 0; m < 12; ++m) remove(take, m, {10 * m, 10 * m + 35});
  remove(take, 5, {0, 200});
  take.flags()[take.sample(77, 5)] = SampleFlag::valid;
  take.position(77, 5) = truth(5, 77).cast<float>();
  for (std::size_t m = 0; m < 12; ++m) remove(take, m, {190, 200});
  expect_whole(take, fill_gaps(take).take);
}

TEST(GapFill, TheBandHoldsTheTruthWithoutTheNoiseOfTheRecording) {
  for (const FillEffort effort : {FillEffort::full, FillEffort::fast}) {
    MarkerSequence take = face(300, 20);
    std::mt19937 random(11);
    std::normal_distribution<float> noise(0.0F, 0.15F);
    for (float& value : take.positions()) value += noise(random);
    for (std::size_t m = 0; m < 20; m += 2) remove(take, m, {50 + 10 * m, 70 + 10 * m});
    const MarkerSequence out = fill_gaps(take, {.effort = effort}).take;
    double inside = 0.0;
    for (std::size_t m = 0; m < 20; m += 2) {
      for (std::size_t f = 50 + 10 * m; f < 70 + 10 * m; ++f) {
        const double error = (out.position(f, m).cast<double>() - truth(m, f)).norm();
        inside += error <= fill_band_90 * out.uncertainty()[out.sample(f, m)] ? 1.0 : 0.0;
      }
    }
    EXPECT_GT(inside / 200.0, 0.80);
    EXPECT_LT(inside / 200.0, 0.999);
  }
}

TEST(GapFill, TheBandOfAMarkerHardlySeenCoversWhatItsNeighboursDo) {
  for (const std::size_t seen : {3U, 7U, 25U}) {  // by hand, and learnt from samples of one moment
    MarkerSequence take = face(300, 20);
    remove(take, 2, {seen, 300});
    const auto result = fill_gaps(take);
    expect_whole(take, result.take);
    std::size_t inside = 0;
    for (std::size_t f = seen; f < 300; ++f) {
      const double error = (result.take.position(f, 2).cast<double>() - truth(2, f)).norm();
      inside += error <= 2.5 * result.take.uncertainty()[result.take.sample(f, 2)] ? 1 : 0;
    }
    EXPECT_GE(static_cast<double>(inside), 0.85 * static_cast<double>(300 - seen)) << seen;
    ASSERT_EQ(result.warnings.size(), 1U);
    EXPECT_NE(result.warnings[0].find("less than 10 % of the frames (m2)"), std::string::npos);
  }
}

TEST(GapFill, AMarkerHardlySeenAmongFewOthersIsKnownToACentimetreAtBest) {
  MarkerSequence take = face(100, 3);
  remove(take, 1, {5, 100});
  const auto result = fill_gaps(take, {.method = FillMethod::linear});
  EXPECT_GE(result.take.uncertainty()[result.take.sample(60, 1)], 10.0F);
}

TEST(GapFill, OneFrameOneMarkerOneSample) {
  MarkerSequence take = MarkerSequence::invalid(5, {{.label = "a"}, {.label = "b"}}, 60.0);
  take.position(2, 0) = Eigen::Vector3f(1, 2, 3);
  take.flags()[take.sample(2, 0)] = SampleFlag::valid;
  std::vector<std::string> logged;
  RunContext ctx;
  ctx.set_log([&](LogLevel, std::string_view text) { logged.emplace_back(text); });
  const auto result = fill_gaps(take, {}, ctx);
  for (std::size_t f = 0; f < 5; ++f) {
    EXPECT_EQ(result.take.position(f, 0), Eigen::Vector3f(1, 2, 3));
    EXPECT_FALSE(result.take.valid(f, 1));
  }
  EXPECT_EQ(result.never_valid, std::vector<std::size_t>{1});
  EXPECT_EQ(result.warnings, logged);
  EXPECT_EQ(logged.size(), 1U);
  EXPECT_TRUE(fill_gaps(MarkerSequence::invalid(0, {{.label = "a"}}, 60.0)).fills.empty());
}

TEST(GapFill, NotFiniteCountsAsMissing) {
  MarkerSequence take = face(60, 6);
  take.position(30, 2).x() = std::numeric_limits<float>::quiet_NaN();
  const auto result = fill_gaps(take);
  ASSERT_EQ(result.fills.size(), 1U);
  EXPECT_TRUE(result.take.filled(30, 2));
  EXPECT_LT(rms_error(result.take, 2, {30, 31}), 0.05);
}

TEST(GapFill, WhatHappensOnceOnlyIsTakenFromTheSurroundings) {
  // A sheet of markers that rests, but for one bulge, which comes and goes inside the gap.
  constexpr std::size_t side = 5, frames = 300;
  std::vector<Marker> names(side * side);
  for (std::size_t m = 0; m < names.size(); ++m) names[m].label = "m" + std::to_string(m);
  MarkerSequence sheet(frames, names, 100.0);
  std::ranges::fill(sheet.flags(), SampleFlag::valid);
  std::ranges::fill(sheet.residuals(), 0.0F);
  std::ranges::fill(sheet.camera_masks(), uint8_t{0});
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0F, 0.05F);
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = (static_cast<double>(f) - 150.0) / 20.0;
    for (std::size_t m = 0; m < names.size(); ++m) {
      const Eigen::Vector3d rest(10.0 * static_cast<double>(m % side),
                                 10.0 * static_cast<double>(m / side), 0.0);
      const double near = (rest - Eigen::Vector3d(15.0, 25.0, 0.0)).squaredNorm() / 900.0;
      sheet.position(f, m) =
          (rest + Eigen::Vector3d(0.0, 0.0, 8.0 * std::exp(-t * t - near))).cast<float>() +
          Eigen::Vector3f(noise(random), noise(random), noise(random));
    }
  }
  MarkerSequence take = sheet;
  constexpr std::size_t marker = 12;
  for (std::size_t f = 80; f < 220; ++f) take.flags()[take.sample(f, marker)] = 0;
  const GapFillResult result = fill_gaps(take);
  double worst = 0.0;
  for (std::size_t f = 80; f < 220; ++f) {
    worst = std::max(worst,
                     double{(result.take.position(f, marker) - sheet.position(f, marker)).norm()});
  }
  EXPECT_LT(worst, 2.0);  // a quarter of the bulge; a straight line misses all 8 mm of it
}

TEST(GapFill, NeverSeesTheSamplesThatWereRemoved) {
  MarkerSequence one = face(240, 15);
  MarkerSequence other = one;
  remove(one, 7, {100, 130});
  remove(other, 7, {100, 130});
  for (std::size_t f = 100; f < 130; ++f) other.position(f, 7) = Eigen::Vector3f(7e6F, -1, 0);
  for (const FillMethod method : {FillMethod::automatic, FillMethod::cubic, FillMethod::pattern,
                                  FillMethod::rigid, FillMethod::pca}) {
    const GapFillOptions options{.method = method, .max_gap_s = 1.0};
    const auto a = fill_gaps(one, options);
    const auto b = fill_gaps(other, options);
    EXPECT_TRUE(std::ranges::equal(a.take.positions(), b.take.positions())) << name_of(method);
    EXPECT_TRUE(std::ranges::equal(a.take.uncertainty(), b.take.uncertainty()));
  }
}

TEST(GapFill, SameBytesForAnyNumberOfThreads) {
  MarkerSequence take = face(240, 15);
  for (std::size_t m = 0; m < 15; ++m) remove(take, m, {12 * m, 12 * m + 20});
  const auto one = fill_gaps(take, {}, RunContext().set_threads(1));
  const auto many = fill_gaps(take, {}, RunContext().set_threads(4));
  EXPECT_TRUE(std::ranges::equal(one.take.positions(), many.take.positions()));
  EXPECT_TRUE(std::ranges::equal(one.take.uncertainty(), many.take.uncertainty()));
}

TEST(GapFill, SplinesFillUpToTheirLimitAndAutoTheRest) {
  MarkerSequence take = face(300, 20);
  remove(take, 7, {100, 106});
  remove(take, 8, {100, 160});
  for (const auto& [method, bound] :
       {std::pair{FillMethod::linear, 0.5}, std::pair{FillMethod::cubic, 0.01},
        std::pair{FillMethod::quintic, 0.001}}) {
    const auto result = fill_gaps(take, {.method = method, .max_gap_s = 0.1});
    ASSERT_EQ(result.fills.size(), 2U);
    EXPECT_EQ(result.fills[0].method, method);
    EXPECT_EQ(result.fills[1].method, FillMethod::automatic);
    EXPECT_LT(rms_error(result.take, 7, {100, 106}), bound) << name_of(method);
    const auto left = fill_gaps(take, {.method = method, .max_gap_s = 0.1, .fill_rest = false});
    EXPECT_EQ(left.fills.size(), 1U);
    EXPECT_FALSE(left.take.valid(120, 8));
  }
}

TEST(GapFill, PatternCopiesADonorThatMovesAlike) {
  MarkerSequence take = face(100, 3);
  for (std::size_t f = 0; f < 100; ++f) {
    take.position(f, 2) = take.position(f, 0) + Eigen::Vector3f(5, 6, 7);
  }
  const MarkerSequence complete = take;
  remove(take, 2, {20, 60});
  const auto result = fill_gaps(take, {.method = FillMethod::pattern, .donor = "m0"});
  EXPECT_EQ(result.fills[0].method, FillMethod::pattern);
  for (std::size_t f = 20; f < 60; ++f) {
    EXPECT_LT((result.take.position(f, 2) - complete.position(f, 2)).norm(), 1e-3F);
  }
  EXPECT_THROW(fill_gaps(take, {.donor = "m9"}), UsageError);
}

TEST(GapFill, RigidFollowsABodyThatTumbles) {
  const std::vector<Eigen::Vector3d> body = {{0, 0, 0}, {60, 0, 0}, {0, 70, 10}, {20, 20, 50}};
  std::vector<Marker> names(4);
  for (std::size_t m = 0; m < 4; ++m) names[m].label = "r" + std::to_string(m);
  MarkerSequence take(200, names, 100.0);
  for (std::size_t f = 0; f < 200; ++f) {
    const double t = static_cast<double>(f) / 100.0;
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(3.0 * t, Eigen::Vector3d(1, 2, 3).normalized())).toRotationMatrix();
    for (std::size_t m = 0; m < 4; ++m) {
      take.position(f, m) = (turn * body[m] + Eigen::Vector3d(100 * t, 5, 900)).cast<float>();
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
    }
  }
  MarkerSequence gapped = take;
  remove(gapped, 3, {40, 160});
  remove(gapped, 1, {0, 10});
  const auto result = fill_gaps(gapped, {.method = FillMethod::rigid});
  ASSERT_EQ(result.fills.size(), 2U);
  for (const Fill& fill : result.fills) {
    EXPECT_EQ(fill.method, FillMethod::rigid);
    for (std::size_t f = fill.frames.begin; f < fill.frames.end; ++f) {
      EXPECT_LT((result.take.position(f, fill.marker) - take.position(f, fill.marker)).norm(),
                2e-3F);
    }
  }
}

TEST(NaturalSpline, ReproducesItsPolynomialsAndScipysValues) {
  const Eigen::VectorXd knots{{0, 1, 2, 6, 7, 9}};
  Eigen::MatrixXd values(6, 2);
  for (Eigen::Index k = 0; k < 6; ++k) {
    values(k, 0) = 3 - 2 * knots[k] + 0.5 * knots[k] * knots[k];
    values(k, 1) = std::sin(knots[k]);
  }
  const Eigen::VectorXd queries{{3.0, 4.5, 8.0}};
  const Eigen::MatrixXd quintic = fill::natural_spline(5, knots, values, queries);
  for (Eigen::Index q = 0; q < 3; ++q) {
    EXPECT_NEAR(quintic(q, 0), 3 - 2 * queries[q] + 0.5 * queries[q] * queries[q], 1e-9);
  }
  // scipy.interpolate.CubicSpline(knots, sin(knots), bc_type="natural")(queries)
  const Eigen::MatrixXd cubic = fill::natural_spline(3, knots, values, queries);
  EXPECT_NEAR(cubic(0, 1), 0.416071160301728, 1e-9);
  EXPECT_NEAR(cubic(1, 1), -0.46184093544041, 1e-9);
  EXPECT_NEAR(cubic(2, 1), 0.844439643304166, 1e-9);
  // scipy.interpolate.make_interp_spline(…, k=5), third and fourth derivatives 0 at both ends
  EXPECT_NEAR(quintic(0, 1), 0.31804378613303, 1e-9);
  EXPECT_NEAR(quintic(1, 1), -0.702184004502575, 1e-9);
  EXPECT_NEAR(quintic(2, 1), 1.08181444187395, 1e-9);
  const Eigen::MatrixXd linear = fill::natural_spline(1, knots, values, queries);
  EXPECT_NEAR(linear(0, 1), 0.75 * std::sin(2.0) + 0.25 * std::sin(6.0), 1e-12);
}

}  // namespace
}  // namespace kinemesh::gap_fill_test
