// The comparison of two performances: against themselves, against the generator's truth of the
// samples, mirrored, and where it cannot mean anything.
#include "analysis/comparison/comparison.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/comparison/asymmetry.h"
#include "analysis/comparison/performance.h"
#include "analysis/comparison/regions.h"
#include "capture/formats/mesh_formats.h"
#include "config/error.h"
#include "config/input_file.h"
#include "tests/support/data.h"
#include "tests/support/sanitizers.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::comparison_test {
namespace {

Performance sample(const std::string& name) {
  return read_performance(all_formats(), test::sample_folder() / (name + ".c3d"));
}

/// A plate of 200 × 200 mm whose left part (x > 0) rises by `left` mm and right part by `right`.
AnimatedMesh plate(double left, double right) {
  const test::Surface grid = test::plane_grid(14, 0.2, 3);
  AnimatedMesh mesh(grid.topology, 120, 60);
  for (std::size_t f = 0; f < 120; ++f) {
    const double t = std::clamp((static_cast<double>(f) / 60.0 - 0.4) / 0.6, 0.0, 1.0);
    const double rise = t * t * t * (10 + t * (6 * t - 15));
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
      Eigen::Vector3d p = 14.0 * (grid.positions[v] - Eigen::Vector3d(7, 7, 0));
      const double bump = std::exp(-(std::pow(std::abs(p.x()) - 50, 2) + p.y() * p.y()) / 800.0);
      p.z() = -p.squaredNorm() / 300.0 + rise * bump * (p.x() > 0 ? left : right);
      mesh.position(f, v) = p.cast<float>();
    }
  }
  return mesh;
}

double largest(const std::vector<float>& values) {
  double most = 0.0;
  for (const float v : values) most = std::max(most, std::abs(static_cast<double>(v)));
  return most;
}

TEST(Comparison, ASubjectComparedWithItselfGivesZeroEverywhere) {
  const Performance anna = sample("anna_surprise");
  const Comparison c = compare_performances(anna.mesh, anna.mesh);
  EXPECT_FALSE(c.poor);
  EXPECT_TRUE(c.warnings.empty());
  const double tolerance = 1e-3 * c.root_area_mm;
  EXPECT_LT(largest(c.shape_mm), tolerance);
  EXPECT_LT(largest(c.motion_difference.values), tolerance);
  ASSERT_TRUE(c.warp);
  EXPECT_NEAR(c.warp->delay_s, 0.0, 5e-4);
  const auto regions = compare_regions(c, anna.mesh.topology(), default_regions(anna.mesh), 0.1);
  ASSERT_EQ(regions.size(), 7U);
  for (const RegionResult& r : regions) {
    EXPECT_LT(r.shape_rms_mm, tolerance);
    EXPECT_LT(r.motion_rms_mm, tolerance);
    ASSERT_EQ(r.a.timing.has_value(), r.b.timing.has_value());
    if (r.a.timing) {
      EXPECT_EQ(r.a.timing->onset_s, r.b.timing->onset_s);
    }
  }
}

TEST(Comparison, OnsetAndPeakOfTheSamplesAreWithinTwoFramesOfTheGenerators) {
  for (const std::string motion : {"happy", "surprise"}) {
    if (test::under_sanitizers && motion == "happy") continue;
    const Performance anna = sample("anna_" + motion), ben = sample("ben_" + motion);
    const Comparison c = compare_performances(anna.mesh, ben.mesh);
    EXPECT_FALSE(c.poor);
    const RegionResult whole =
        compare_regions(c, ben.mesh.topology(), default_regions(anna.mesh), 0.1).front();
    for (const auto& [name, course] : {std::pair{"anna_", &whole.a}, {"ben_", &whole.b}}) {
      const auto truth = nlohmann::json::parse(
          read_file(test::sample_folder() / "truth" / (name + motion + ".json")));
      ASSERT_TRUE(course->timing);
      EXPECT_NEAR(course->timing->onset_s, truth["onset_s"].get<double>(), 2.0 / 120)
          << name << motion;
      EXPECT_NEAR(course->timing->peak_s, truth["peak_s"].get<double>(), 2.0 / 120)
          << name << motion;
      EXPECT_TRUE(course->timing->comes_back);
    }
  }
}

TEST(Comparison, MotionDifferenceIsFreeOfShapeAndShapeOfMotion) {
  const AnimatedMesh a = plate(10, 10), b = plate(6, 6);
  const Comparison c = compare_performances(a, b);
  EXPECT_LT(largest(c.shape_mm), 1e-3);                        // the same at rest
  EXPECT_NEAR(largest(c.motion_difference.values), 4.0, 0.4);  // 10 mm against 6
  ASSERT_TRUE(c.warp);
  EXPECT_NEAR(c.warp->amplitude, 0.6, 0.25);
}

TEST(Comparison, AsymmetryChangesItsSignWithTheSides) {
  const AnimatedMesh a = plate(10, 5), b = plate(5, 10);
  const Comparison c = compare_performances(a, b);
  const auto rows = asymmetry_of(compare_regions(c, b.topology(), default_regions(a), 0.1), {});
  const auto middle = std::ranges::find(rows, std::string("middle region"), &AsymmetryRow::name);
  ASSERT_NE(middle, rows.end());
  EXPECT_GT(std::abs(middle->a.percent), 40);
  EXPECT_NEAR(middle->a.percent, -middle->b.percent, 5);
}

TEST(Comparison, WhatCannotBeComparedIsRefusedOrSaidFirst) {
  const AnimatedMesh a = plate(10, 10);
  AnimatedMesh metres = a;
  for (float& x : metres.positions()) x *= 1000.0F;
  try {
    compare_performances(a, metres);
    ADD_FAILURE();
  } catch (const NoResultError& e) {
    EXPECT_NE(std::string(e.what()).find("1000 times"), std::string::npos) << e.what();
    EXPECT_NE(e.details().remedy.find("similarity"), std::string::npos);
  }
  ComparisonOptions similarity;
  similarity.alignment = ShapeAlignment::similarity;
  const Comparison scaled = compare_performances(a, metres, similarity);
  EXPECT_NEAR(scaled.scale, 1e-3, 1e-6);
  EXPECT_LT(largest(scaled.shape_mm), 0.01);

  AnimatedMesh still = a;
  for (std::size_t f = 1; f < still.frame_count(); ++f) still.frame(f) = still.frame(0);
  const Comparison c = compare_performances(a, still);
  EXPECT_FALSE(c.warp);
  ASSERT_FALSE(c.warnings.empty());
  EXPECT_NE(c.warnings[0].find("not compared"), std::string::npos);
  EXPECT_THROW(compare_performances(a, AnimatedMesh(a.shared_topology(), 0, 60)), InputError);
}

TEST(Comparison, HoldingStillTakesTheHeadsMotionOut) {
  const AnimatedMesh still = plate(8, 8);
  AnimatedMesh moving = still;
  for (std::size_t f = 0; f < moving.frame_count(); ++f) {
    const Eigen::AngleAxisf turn(0.002F * static_cast<float>(f),
                                 Eigen::Vector3f(1, 2, 3).normalized());
    moving.frame(f) = (moving.frame(f) * turn.toRotationMatrix().transpose()).eval();
    moving.frame(f).col(1).array() += 0.3F * static_cast<float>(f);
  }
  hold_still(moving);
  double worst = 0.0;
  for (std::size_t f = 0; f < moving.frame_count(); ++f)
    worst = std::max<double>(worst, (moving.frame(f) - still.frame(f)).rowwise().norm().maxCoeff());
  EXPECT_LT(worst, 0.5);
}

}  // namespace
}  // namespace kinemesh::comparison_test
