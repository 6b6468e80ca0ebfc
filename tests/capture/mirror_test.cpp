#include "capture/fill/mirror.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/gap_fill.h"

namespace kinemesh::mirror_test {
namespace {

/// Twenty-five places on each half of a dome, mirror images about x = 0 but for `scatter` mm.
std::vector<Eigen::Vector3d> dome(double scatter) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> shift(0.0, 1.0);
  std::vector<Eigen::Vector3d> out;
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i < 25; ++i) {
      const double x = side * (6.0 + 12.0 * (i % 5)) + scatter * shift(random);
      const double y = 14.0 * (i / 5) - 28.0 + scatter * shift(random);
      // Narrower and flatter below: the two halves are alike, top and bottom are not.
      out.emplace_back(x * (1.0 + 0.004 * y), y, -x * x / 90.0 - y * y / 160.0 - 0.15 * y);
    }
  }
  return out;
}

MarkerSequence still(const std::vector<Eigen::Vector3d>& places, std::size_t frames) {
  std::vector<Marker> names(places.size());
  for (std::size_t m = 0; m < names.size(); ++m) names[m].label = "m" + std::to_string(m);
  MarkerSequence take(frames, names, 100.0);
  std::ranges::fill(take.flags(), SampleFlag::valid);
  std::ranges::fill(take.residuals(), 0.0F);
  std::ranges::fill(take.camera_masks(), uint8_t{0});
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < places.size(); ++m) {
      take.position(f, m) = places[m].cast<float>();
    }
  }
  return take;
}

TEST(Mirror, FindsThePlaneBetweenTheHalvesOfAFace) {
  const auto mirror = fill::find_mirror(fill::Trajectories(still(dome(1.5), 3)));
  ASSERT_TRUE(mirror);
  EXPECT_GT(std::abs(mirror->plane.normal.x()), std::cos(4.0 * std::acos(-1.0) / 180.0));
  EXPECT_LT(std::abs(mirror->plane.side(Eigen::Vector3d::Zero())), 2.0);
}

TEST(Mirror, FindsNoneWhereThereIsNone) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> anywhere(-50.0, 50.0);
  std::vector<Eigen::Vector3d> cloud;
  for (int i = 0; i < 60; ++i) {
    cloud.emplace_back(anywhere(random), anywhere(random), anywhere(random));
  }
  EXPECT_FALSE(fill::find_mirror(fill::Trajectories(still(cloud, 3))));
  cloud.resize(7);
  EXPECT_FALSE(fill::find_mirror(fill::Trajectories(still(cloud, 3))));
}

/// A blink, narrow from top to bottom, on both halves, once, inside the gap, on the left alone if
/// `one_sided`.
double worst_error(bool one_sided) {
  constexpr std::size_t frames = 300, marker = 12;
  const std::vector<Eigen::Vector3d> places = dome(0.0);
  MarkerSequence truth = still(places, frames);
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0F, 0.05F);
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = (static_cast<double>(f) - 150.0) / 8.0;
    for (std::size_t m = 0; m < places.size(); ++m) {
      const bool right = m >= 25;
      const Eigen::Vector3d middle = places[right ? 37 : marker];
      const Eigen::Vector3d away = places[m] - middle;
      const double near = away.x() * away.x() / 300.0 + away.y() * away.y() / 60.0;
      const double size = 8.0 * (right && one_sided ? 0.0 : 1.0) * std::exp(-t * t - near);
      truth.position(f, m) += Eigen::Vector3d(0.0, -size, 0.0).cast<float>() +
                              Eigen::Vector3f(noise(random), noise(random), noise(random));
    }
  }
  MarkerSequence take = truth;
  for (std::size_t f = 110; f < 190; ++f) take.flags()[take.sample(f, marker)] = 0;
  const GapFillResult result = fill_gaps(take);
  double worst = 0.0;
  for (std::size_t f = 110; f < 190; ++f) {
    worst = std::max(worst,
                     double{(result.take.position(f, marker) - truth.position(f, marker)).norm()});
  }
  return worst;
}

TEST(Mirror, WhatHappensOnceOnlyIsTakenFromTheOtherHalfOfTheFace) {
  // Above and below nothing moves; the image does the same.
  EXPECT_LT(worst_error(false), 2.0);
}

TEST(Mirror, AStillOtherHalfDoesNotMakeItWorseThanAStraightLine) {
  EXPECT_LT(worst_error(true), 8.3);
}

}  // namespace
}  // namespace kinemesh::mirror_test
