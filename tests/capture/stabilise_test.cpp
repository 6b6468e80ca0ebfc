#include "capture/stabilise.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "capture/rigid_markers.h"
#include "config/error.h"

namespace kinemesh::stabilise_test {
namespace {

/// A head: six rig markers, then skin on a 20 mm grid whose lower part swings like a jaw.
struct Head {
  std::vector<Marker> markers;
  std::vector<Eigen::Vector3d> rest;
  static constexpr std::size_t rig = 6;
};

Head head() {
  Head h;
  h.rest = {{-80, 60, 900},  {80, 62, 905},  {0, 130, 900},
            {-60, 100, 960}, {55, 105, 955}, {3, 70, 1000}};
  for (std::size_t i = 0; i < Head::rig; ++i)
    h.markers.push_back({.label = "rig" + std::to_string(i)});
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 6; ++j) {
      const double x = 20.0 * i - 40.0;
      const double y = 20.0 * j - 60.0;
      h.rest.emplace_back(x, y, 1010.0 - 0.01 * (x * x + y * y));
      h.markers.push_back({.label = "skin" + std::to_string(6 * i + j)});
    }
  }
  return h;
}

Eigen::Isometry3d pose(std::size_t frame) {
  const double t = static_cast<double>(frame) / 100.0;
  Eigen::Isometry3d p = Eigen::Isometry3d::Identity();
  p.translate(Eigen::Vector3d(30.0 * std::sin(t), 20.0 * std::sin(1.7 * t), 1200.0));
  p.rotate(Eigen::AngleAxisd(0.4 * std::sin(0.9 * t), Eigen::Vector3d(1, 2, 0.5).normalized()));
  p.translate(Eigen::Vector3d(0, 0, -900.0));
  return p;
}

Eigen::Vector3d skin_motion(const Eigen::Vector3d& rest, std::size_t frame) {
  const double t = static_cast<double>(frame) / 100.0;
  const double low = 1.0 / (1.0 + std::exp((rest.y() + 10.0) / 8.0));
  return {0.0, -6.0 * low * (1.0 - std::cos(3.0 * t)), 1.5 * std::sin(2.3 * t + 0.05 * rest.x())};
}

MarkerSequence record(std::size_t frames, double noise_mm) {
  const Head h = head();
  MarkerSequence take(frames, h.markers, 100.0);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, noise_mm > 0.0 ? noise_mm : 1.0);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < h.rest.size(); ++m) {
      Eigen::Vector3d p = h.rest[m];
      if (m >= Head::rig) p += skin_motion(h.rest[m], f);
      p = pose(f) * p;
      if (noise_mm > 0.0) p += Eigen::Vector3d(noise(random), noise(random), noise(random));
      take.position(f, m) = p.cast<float>();
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
    }
  }
  return take;
}

const StabiliseOptions by_name{.rigid = {"rig*"}};

TEST(Stabilise, TakesTheHeadsMotionOutExactly) {
  const MarkerSequence take = record(300, 0.0);
  const auto result = stabilise_head(take, by_name);
  const Head h = head();
  for (std::size_t f = 0; f < 300; f += 17) {
    const Eigen::Isometry3d motion = pose(f) * pose(0).inverse();
    EXPECT_LT((result.poses[f].rotation - motion.rotation()).norm(), 1e-5);
    for (std::size_t m = 0; m < h.rest.size(); ++m) {
      Eigen::Vector3d p = h.rest[m];
      if (m >= Head::rig) p += skin_motion(p, f);
      EXPECT_LT((result.take.position(f, m).cast<double>() - pose(0) * p).norm(), 2e-3);
    }
  }
  EXPECT_EQ(result.reference_frame, 0U);
  EXPECT_LT(result.rms_error_mm, 1e-3);
  EXPECT_EQ(result.interpolated_frames, 0U);
  EXPECT_TRUE(result.warnings.empty());
}

TEST(Stabilise, NoiseIsLeftAndReported) {
  const auto result = stabilise_head(record(300, 0.2), by_name);
  // Six markers have 18 coordinates, of which the pose takes six: E ‖r‖² = 0.2² · 12 / 6.
  EXPECT_NEAR(result.rms_error_mm, 0.2 * std::sqrt(2.0), 0.01);
  for (const double w : result.shape.weights) EXPECT_NEAR(w, 1.0, 0.35);
}

TEST(Stabilise, AMarkerThatFitsWorseCountsLess) {
  MarkerSequence take = record(300, 0.1);
  for (std::size_t f = 0; f < 300; ++f) {
    take.position(f, 2).x() += 5.0F * std::sin(0.37F * static_cast<float>(f));
  }
  const auto result = stabilise_head(take, by_name);
  EXPECT_LT(result.shape.weights[2], 0.2);
  EXPECT_GT(result.shape.residuals_mm[2], 2.0);
}

TEST(Stabilise, PosesWithTooFewMarkersAreInterpolatedAndFlagged) {
  MarkerSequence take = record(300, 0.0);
  for (std::size_t f = 0; f < 300; ++f) {
    for (std::size_t m = 0; m < Head::rig; ++m) {
      const bool out = (f >= 100 && f < 104 && m > 1) || f < 2 || (f % 6 == m);
      if (out) take.flags()[take.sample(f, m)] = 0;
    }
  }
  const auto result = stabilise_head(take, by_name);
  EXPECT_EQ(result.interpolated_frames, 6U);
  EXPECT_EQ(result.warnings.size(), 1U);
  for (const std::size_t f : {0U, 1U, 100U, 103U}) {
    EXPECT_TRUE(result.poses[f].interpolated);
    EXPECT_TRUE(std::isnan(result.poses[f].error_mm));
    const Eigen::Isometry3d motion = pose(f) * pose(result.reference_frame).inverse();
    EXPECT_LT((result.poses[f].rotation - motion.rotation()).norm(), 0.02);
    const Eigen::Vector3d centre = pose(0) * Eigen::Vector3d(0, 80, 950);
    EXPECT_LT(
        (result.poses[f].rotation * centre + result.poses[f].translation - motion * centre).norm(),
        1.0);
  }
  EXPECT_FALSE(result.poses[104].interpolated);
  EXPECT_LT(result.rms_error_mm, 1e-3);
}

void hide(MarkerSequence& take, std::initializer_list<std::size_t> markers, std::size_t from,
          std::size_t to) {
  for (std::size_t f = from; f < to; ++f) {
    for (const std::size_t m : markers) take.flags()[take.sample(f, m)] = 0;
  }
}

/// Largest distance of a skin marker in these frames from where it is on a head at rest.
double worst_skin(const MarkerSequence& steady, const Eigen::Isometry3d& rest, std::size_t from,
                  std::size_t to) {
  const Head h = head();
  double worst = 0.0;
  for (std::size_t f = from; f < to; ++f) {
    for (std::size_t m = Head::rig; m < h.rest.size(); ++m) {
      const Eigen::Vector3d p = rest * (h.rest[m] + skin_motion(h.rest[m], f));
      worst = std::max(worst, (steady.position(f, m).cast<double>() - p).norm());
    }
  }
  return worst;
}

TEST(Stabilise, AMarkerNeverSeenWithThreeOthersIsLeftOutAndNamed) {
  MarkerSequence take = record(300, 0.0);
  hide(take, {3}, 0, 280);
  hide(take, {0, 1, 5}, 280, 300);  // 2, 3 and 4 are seen, and 3 has no place
  const auto result = stabilise_head(take, by_name);
  EXPECT_EQ(result.interpolated_frames, 20U);
  EXPECT_EQ(result.shape.weights[3], 0.0);
  EXPECT_TRUE(std::isnan(result.shape.residuals_mm[3]));
  ASSERT_EQ(result.warnings.size(), 2U);
  EXPECT_NE(result.warnings[1].find("rig3."), std::string::npos) << result.warnings[1];
  EXPECT_LT(worst_skin(result.take, pose(0), 0, 280), 2e-3);
  EXPECT_LT(worst_skin(result.take, pose(0), 280, 300), 15.0);  // held: the head moves on by that
}

TEST(Stabilise, ASecondSubjectWhoFollowsIsABodyOfItsOwn) {
  MarkerSequence take = record(300, 0.0);
  hide(take, {0, 1, 2}, 150, 300);
  hide(take, {3, 4, 5}, 0, 150);
  const auto result = stabilise_head(take, by_name);
  EXPECT_EQ(result.interpolated_frames, 0U);
  EXPECT_LT(result.rms_error_mm, 1e-3);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("frame 151 are never seen together"), std::string::npos);
  EXPECT_LT(worst_skin(result.take, pose(0), 0, 150), 2e-3);
  for (std::size_t f = 151; f < 300; ++f) {  // at rest, wherever that is
    EXPECT_LT((result.take.position(f, 4) - result.take.position(150, 4)).norm(), 2e-3F);
  }
}

TEST(Stabilise, TwoHeadsAtOnceAreNoBody) {
  MarkerSequence take = record(200, 0.0);
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    take.markers()[m].subject = m % 2 == 0 ? "anna" : "ben";
  }
  EXPECT_EQ(stabilise_head(take, by_name).interpolated_frames, 0U);  // one head, tracked as two
  for (std::size_t f = 0; f < 200; ++f) {
    for (std::size_t m = 1; m < take.marker_count(); m += 2) {
      take.position(f, m).x() += 20.0F * std::sin(0.1F * static_cast<float>(f));
    }
  }
  try {
    stabilise_head(take, by_name);
    FAIL();
  } catch (const NoResultError& e) {
    EXPECT_NE(std::string(e.what()).find("anna and ben"), std::string::npos) << e.what();
  }
  EXPECT_LT(stabilise_head(take, {.rigid = {"anna:rig*"}}).rms_error_mm, 1e-3);
}

TEST(Stabilise, NamedMarkersThatAreNotFixedAreSaid) {
  const auto result = stabilise_head(record(300, 0.0), {.rigid = {"rig*", "skin2*", "skin0"}});
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings.back().find("in a tenth of the frames: skin0 ("), std::string::npos)
      << result.warnings.back();
  EXPECT_EQ(result.warnings.back().find("rig"), result.warnings.back().find("rigid"));
}

TEST(Stabilise, MarkersJoinRoundByRound) {
  MarkerSequence take = record(300, 0.0);
  hide(take, {4, 5}, 0, 100);
  hide(take, {0, 5}, 100, 200);  // 4 joins by 1, 2 and 3
  hide(take, {0, 1}, 200, 250);  // 5 joins by 2, 3 and 4
  hide(take, {0, 1, 2}, 250, 300);
  const auto result = stabilise_head(take, by_name);
  EXPECT_LT(worst_skin(result.take, pose(0), 0, 300), 2e-3);
  EXPECT_EQ(result.interpolated_frames, 0U);
  EXPECT_TRUE(result.warnings.empty());
}

TEST(Stabilise, TheReferenceFrameKeepsItsPlace) {
  const MarkerSequence take = record(50, 0.0);
  const auto result = stabilise_head(take, {.rigid = {"rig*"}, .reference_frame = 21});
  EXPECT_EQ(result.reference_frame, 20U);
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    EXPECT_LT((result.take.position(20, m) - take.position(20, m)).norm(), 1e-3F);
  }
}

TEST(Stabilise, SaysWhatIsMissing) {
  MarkerSequence take = record(20, 0.0);
  EXPECT_THROW(stabilise_head(take, {.rigid = {"nose"}}), UsageError);
  try {
    stabilise_head(take, {.rigid = {"rig0", "rig1", "rgi2"}});
    FAIL();
  } catch (const NoResultError& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("--rigid names 2 of the take"), std::string::npos) << text;
    EXPECT_NE(text.find("rgi2 (did you mean rig2?)"), std::string::npos) << text;
  }
  const auto result = stabilise_head(take, {.rigid = {"rig0", "rig1", "rig2", "rgi3"}});
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("rgi3 (did you mean"), std::string::npos);
  EXPECT_THROW(stabilise_head(take, {.rigid = {"rig*"}, .reference_frame = 99}), UsageError);
  for (std::size_t f = 0; f < 20; ++f) {  // on one line
    for (std::size_t m = 0; m < Head::rig; ++m) {
      take.position(f, m) = Eigen::Vector3f(10.0F * static_cast<float>(m), 0, 0);
    }
  }
  EXPECT_THROW(stabilise_head(take, by_name), NoResultError);
  EXPECT_THROW(stabilise_head(MarkerSequence::invalid(5, take.markers(), 100.0), by_name),
               NoResultError);
  EXPECT_THROW(stabilise_head(MarkerSequence::invalid(0, take.markers(), 100.0)), NoResultError);
}

TEST(RigidMarkers, AreFoundFromTheMotionAndSkinIsNot) {
  for (const double noise : {0.02, 0.2}) {
    const auto found = find_rigid_markers(record(400, noise));
    EXPECT_EQ(found.markers, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5})) << noise;
    EXPECT_NEAR(found.residual_mm, noise * std::sqrt(3.0), 0.25 * noise * std::sqrt(3.0));
  }
}

TEST(RigidMarkers, JumpsAndGapsDoNotMatter) {
  MarkerSequence take = record(400, 0.1);
  for (std::size_t f = 0; f < 400; ++f) {
    take.flags()[take.sample(f, f % Head::rig)] = 0;
    if (f % 150 == 7) take.position(f, 3).array() += 40.0F;
  }
  const auto found = find_rigid_markers(take);
  EXPECT_EQ(found.markers, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
  const auto result = stabilise_head(take);
  EXPECT_TRUE(result.chosen_from_motion);
  EXPECT_EQ(result.warnings.size(), 1U);
}

TEST(RigidMarkers, WhatNeverKeepsItsShapeIsNoHead) {
  MarkerSequence take = record(200, 12.0);
  try {
    stabilise_head(take);
    FAIL() << "a cloud was taken for a head";
  } catch (const NoResultError& e) {
    EXPECT_NE(std::string(e.what()).find("No markers move as one rigid body"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("--rigid"), std::string::npos);
  }
}

TEST(RigidMarkers, OfNothingAreNone) {
  EXPECT_TRUE(find_rigid_markers(MarkerSequence()).markers.empty());
  EXPECT_TRUE(find_rigid_markers(record(1, 0.1)).markers.empty());
}

TEST(RigidFit, IsTheRotationEvenWhenAReflectionFitsBetter) {
  const std::vector<Eigen::Vector3d> a = {{0, 0, 0}, {10, 0, 0}, {0, 20, 0}, {0, 0, 30}};
  std::vector<Eigen::Vector3d> mirrored = a;
  for (auto& p : mirrored) p.x() = -p.x();
  EXPECT_NEAR(fit_rigid(a, mirrored).rotation.determinant(), 1.0, 1e-12);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -1, 2).normalized()).toRotationMatrix();
  std::vector<Eigen::Vector3d> b;
  for (const auto& p : a) b.emplace_back(turn * p + Eigen::Vector3d(1, 2, 3));
  const RigidFit fit = fit_rigid(a, b);
  EXPECT_LT((fit.rotation - turn).norm(), 1e-12);
  EXPECT_LT(fit.rms, 1e-12);
  EXPECT_LT((fit.undo(fit.apply(a[1])) - a[1]).norm(), 1e-12);
  b[3] += Eigen::Vector3d(5, 5, 5);  // a weight of zero leaves it out
  EXPECT_LT((fit_rigid(a, b, std::vector<double>{1, 1, 1, 0}).rotation - turn).norm(), 1e-12);
  EXPECT_EQ(fit_rigid({}, {}).rotation, Eigen::Matrix3d::Identity());
}

}  // namespace
}  // namespace kinemesh::stabilise_test
