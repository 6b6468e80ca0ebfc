// Descriptors and their distances.
#include "analysis/descriptors.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <numeric>

#include "config/error.h"
#include "tests/support/deforming_shapes.h"

namespace kinemesh::descriptors_test {
namespace {

using test::make_sheet;

std::vector<float> sine(std::size_t samples, double phase = 0.0) {
  std::vector<float> curve(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(samples - 1);
    curve[i] = static_cast<float>(0.5 + 0.5 * std::sin(2 * std::numbers::pi * t + phase));
  }
  return curve;
}

TEST(CurveDistance, SameMotionAtOtherFrameCountsIsNear) {
  const auto a = sine(139), b = sine(169);
  EXPECT_LT(curve_distance(a, b), 1e-3);
  EXPECT_EQ(curve_distance(a, a), 0.0);
  // Two sines a quarter apart: the root mean square of their difference is 1/2.
  EXPECT_NEAR(curve_distance(a, sine(100, std::numbers::pi / 2)), 0.5, 0.01);
  EXPECT_NEAR(curve_distance(a, b), curve_distance(b, a), 1e-12);
  const std::vector<float> constant{0.25F}, other{0.75F, 0.75F};
  EXPECT_NEAR(curve_distance(constant, other), 0.5, 1e-7);
  EXPECT_EQ(curve_distance({}, a), 0.0);
}

std::vector<float> histogram_at(std::size_t octant, std::size_t bin) {
  std::vector<float> h(256, 0.0F);
  h[octant * 32 + bin] = 1.0F;
  return h;
}

TEST(HistogramDistance, IsTheAngleThatMassMoves) {
  // From azimuth bin 0 to bin 4 of the second elevation: opposite sides of a circle at 67.5°.
  const double around = 2.0 * std::asin(std::sin(3.0 * std::numbers::pi / 8));
  EXPECT_NEAR(histogram_distance(histogram_at(0, 8), histogram_at(0, 12)), around, 1e-6);
  // Bins 0 and 7 are neighbours over the wrap.
  EXPECT_NEAR(histogram_distance(histogram_at(3, 8), histogram_at(3, 15)),
              histogram_distance(histogram_at(3, 8), histogram_at(3, 9)), 1e-6);
  EXPECT_EQ(histogram_distance(histogram_at(0, 8), histogram_at(0, 8)), 0.0);
  EXPECT_EQ(histogram_distance(histogram_at(0, 8), histogram_at(1, 8)), 0.0);  // nothing shared
}

TEST(HistogramDistance, SplitsAndMergesMass) {
  // Half of the mass stays, half moves: half the distance.
  auto both = histogram_at(2, 8);
  both[2 * 32 + 8] = both[2 * 32 + 12] = 0.5F;
  const double whole = histogram_distance(histogram_at(2, 8), histogram_at(2, 12));
  EXPECT_NEAR(histogram_distance(histogram_at(2, 8), both), 0.5 * whole, 1e-6);
  // The triangle inequality, on many random histograms.
  uint64_t state = 1;
  const auto random = [&] {
    std::vector<float> h(256);
    for (float& x : h) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      x = static_cast<float>(state >> 40U);
    }
    return h;
  };
  for (int i = 0; i < 20; ++i) {
    const auto a = random(), b = random(), c = random();
    EXPECT_LE(histogram_distance(a, c), histogram_distance(a, b) + histogram_distance(b, c) + 1e-6);
    EXPECT_NEAR(histogram_distance(a, b), histogram_distance(b, a), 1e-6);
  }
}

/// Descriptors of the vertex nearest to `at` in a bump animation.
Feature described(const test::Sheet& sheet, const AnimatedMesh& mesh, const Eigen::Vector2d& at,
                  uint32_t frame) {
  const auto deformation = deformation_of(mesh);
  Feature f{.vertex = 0, .frame = frame, .sigma_mm = 8, .tau_s = 0.08};
  double nearest = 1e9;
  for (std::size_t v = 0; v < sheet.positions.size(); ++v) {
    const double d = (sheet.positions[v].head<2>() - at).norm();
    if (d < nearest) f.vertex = static_cast<VertexIndex>(v);
    nearest = std::min(nearest, d);
  }
  FeatureSet set{"", mesh.vertex_count(), mesh.frame_count(), mesh.rate_hz, 0, {f}};
  describe_features(set, mesh, deformation);
  return set.features[0];
}

TEST(AnimMeshHog, SumsToOneAndDoesNotFeelPoseOrSize) {
  const auto sheet = make_sheet(120, 120, 4, 1);
  const auto mesh = test::bumps(sheet, {{{60, 60}, 12, 0.5, 0.1, 10, {40, 10}}}, 1, 40);
  const Feature f = described(sheet, mesh, {62, 55}, 20);
  const auto& h = f.descriptor.histogram;
  ASSERT_EQ(h.size(), 256U);
  EXPECT_NEAR(std::accumulate(h.begin(), h.end(), 0.0), 1.0, 1e-5);
  for (const float x : h) EXPECT_GE(x, 0.0F);
  AnimatedMesh moved = mesh;
  const Eigen::AngleAxisf turn(1.1F, Eigen::Vector3f(1, -2, 0.5F).normalized());
  for (std::size_t k = 0; k < moved.frame_count(); ++k) {
    for (VertexIndex v = 0; v < moved.vertex_count(); ++v) {
      moved.position(k, v) = turn * moved.position(k, v).eval() + Eigen::Vector3f(300, 0, -200);
    }
  }
  const Feature g = described(sheet, moved, {62, 55}, 20);
  EXPECT_LT(histogram_distance(h, g.descriptor.histogram), 0.05);
}

TEST(AnimMeshHog, TellsOtherMotionApart) {
  const auto sheet = make_sheet(120, 120, 4, 2), denser = make_sheet(120, 120, 3, 3);
  const test::Bump bump{{60, 60}, 12, 0.5, 0.1, 10, {60, 0}};
  const test::Bump other{{66, 52}, 30, 0.4, 0.3, 12};
  const Feature a = described(sheet, test::bumps(sheet, {bump}, 1, 40), {64, 56}, 20);
  const Feature b = described(denser, test::bumps(denser, {bump}, 1, 40), {64, 56}, 20);
  const Feature c = described(sheet, test::bumps(sheet, {other}, 1, 40), {64, 56}, 20);
  EXPECT_LT(histogram_distance(a.descriptor.histogram, b.descriptor.histogram),
            0.6 * histogram_distance(a.descriptor.histogram, c.descriptor.histogram));
}

TEST(Descriptors, CurvesAreNormalisedAndClippedEndsWork) {
  const auto sheet = make_sheet(80, 80, 4, 4);
  const auto mesh = test::bumps(sheet, {{{40, 40}, 12, 0.1, 0.2, 10}}, 1, 30);
  for (const uint32_t frame : {0U, 3U, 29U}) {
    const Feature f = described(sheet, mesh, {40, 40}, frame);
    EXPECT_EQ(f.descriptor.displacement.size(), 29U);
    EXPECT_EQ(f.descriptor.deformation.size(), 30U);
    for (const float d : f.descriptor.displacement) EXPECT_LE(d, 1.0F);
    for (const float h : f.descriptor.histogram) EXPECT_TRUE(std::isfinite(h));
  }
}

TEST(Descriptors, DisplacementFeaturesCompareByDisplacementAlone) {
  Feature a, b;
  a.descriptor.displacement = sine(50);
  b.descriptor.displacement = sine(50, 1.0);
  a.descriptor.deformation = sine(51);
  b.descriptor.deformation = sine(51, 2.0);
  const double moved = curve_distance(a.descriptor.displacement, b.descriptor.displacement);
  const double deformed = curve_distance(a.descriptor.deformation, b.descriptor.deformation);
  EXPECT_NEAR(descriptor_distance(a, b, {2.0, 3.0, 1.0}), 2 * moved + 3 * deformed, 1e-12);
  b.kind = FeatureKind::displacement;
  EXPECT_EQ(descriptor_distance(a, b), moved);
  FeatureSet set{"", 10, 10, 30, 0, {{.vertex = 99}}};
  const auto sheet = make_sheet(20, 20, 5, 5);
  const auto mesh = test::animate(sheet.topology, {sheet.positions, sheet.positions}, 30);
  EXPECT_THROW(describe_features(set, mesh, deformation_of(mesh)), UsageError);
}

}  // namespace
}  // namespace kinemesh::descriptors_test
