// Matches that are not where the others say are taken back; others are kept.
#include "analysis/match_consensus.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include <cmath>
#include <functional>

namespace kinemesh::match_consensus_test {
namespace {

using Shape = std::function<Eigen::Vector3d(double, double)>;

/// 4 × 5 places on a sheet of 1 × 1 with its distances over the surface, laid out in space; the
/// place `moved` lies `by` from where it should.
FeaturePlaces on_sheet(const Shape& shape, double stretch = 1.0, std::size_t moved = 99,
                       double by = 0.0) {
  FeaturePlaces result{.root_area_mm = 100.0};
  std::vector<Eigen::Vector2d> flat;
  for (int i = 0; i < 20; ++i) {
    Eigen::Vector2d at(0.1 + 0.25 * (i % 4) + 0.02 * (i % 3), 0.1 + 0.2 * (i / 4));
    if (flat.size() == moved) at += by * Eigen::Vector2d(0.6, 0.8);
    const Eigen::Vector3d p = shape(at.x(), at.y());
    const Eigen::Vector3d u = shape(at.x() + 1e-5, at.y()) - p,
                          v = shape(at.x(), at.y() + 1e-5) - p;
    flat.push_back(at);
    result.places.push_back({.index = static_cast<uint32_t>(i),
                             .position = 100.0 * p,
                             .normal = u.cross(v).normalized()});
  }
  result.distances.resize(20, 20);
  for (Eigen::Index i = 0; i < 20; ++i) {
    for (Eigen::Index k = 0; k < 20; ++k) {
      Eigen::Vector2d d = flat[static_cast<std::size_t>(i)] - flat[static_cast<std::size_t>(k)];
      d.x() *= stretch;
      result.distances(i, k) = d.norm();
    }
  }
  return result;
}

Eigen::Vector3d level(double x, double y) { return {x, y, 0.1 * x * x}; }

/// The indices that are taken back when each place is matched to its own number.
std::vector<uint32_t> taken_back(const FeaturePlaces& a, const FeaturePlaces& b,
                                 double limit = FeatureMatchingOptions().reject) {
  const FeatureMatchingOptions options;  // the energy keeps a reference
  const FeatureEnergy energy(a, b, options);
  std::vector<FeatureMatch> matches, rejected;
  for (uint32_t k = 0; k < a.places.size(); ++k) matches.push_back({.source = k, .target = k});
  take_back_misfits(energy, limit, matches, rejected);
  EXPECT_EQ(matches.size() + rejected.size(), a.places.size());
  std::vector<uint32_t> result;
  for (const FeatureMatch& m : rejected) {
    EXPECT_TRUE(std::isfinite(m.misfit));
    result.push_back(m.source);
  }
  return result;
}

TEST(MatchConsensus, TheOneThatIsOffIsTakenBack) {
  const FeaturePlaces a = on_sheet(level);
  for (const std::size_t moved : {0, 7, 13}) {
    EXPECT_EQ(taken_back(a, on_sheet(level, 1.0, moved, 0.08)),
              std::vector<uint32_t>{static_cast<uint32_t>(moved)});
    EXPECT_TRUE(taken_back(a, on_sheet(level, 1.0, moved, 0.08), 0.0).empty());  // 0: none
    EXPECT_TRUE(taken_back(a, on_sheet(level, 1.0, moved, 0.01)).empty());
  }
}

TEST(MatchConsensus, OtherProportionsAreNoReason) {
  const auto wide = [](double x, double y) { return level(1.15 * x, y); };
  const FeaturePlaces a = on_sheet(level);
  EXPECT_TRUE(taken_back(a, on_sheet(wide, 1.15)).empty());
  EXPECT_EQ(taken_back(a, on_sheet(wide, 1.15, 6, 0.09)), std::vector<uint32_t>{6});
}

TEST(MatchConsensus, PlaceAndSizeAreNoReason) {
  const Eigen::AngleAxisd turn(2.5, Eigen::Vector3d(1, 2, 3).normalized());
  const auto elsewhere = [&](double x, double y) -> Eigen::Vector3d {
    return turn * level(x, y) + Eigen::Vector3d(5, -3, 8);
  };
  EXPECT_TRUE(taken_back(on_sheet(level), on_sheet(elsewhere)).empty());
}

TEST(MatchConsensus, AnotherPoseIsNoReason) {
  // The same distances over the surface, but folded like an arm: by 100° over a fifth of the sheet.
  const auto folded = [](double x, double y) -> Eigen::Vector3d {
    const double radius = 0.2 / 1.75, angle = std::clamp((y - 0.4) / radius, 0.0, 1.75);
    const double rest = std::max(0.0, y - 0.6);
    return {x, std::min(y, 0.4) + radius * std::sin(angle) + rest * std::cos(angle),
            radius * (1.0 - std::cos(angle)) + rest * std::sin(angle)};
  };
  const auto flat = [](double x, double y) -> Eigen::Vector3d { return {x, y, 0.0}; };
  EXPECT_TRUE(taken_back(on_sheet(flat), on_sheet(folded)).empty());
}

TEST(MatchConsensus, PlacesAllAlikeAreAnswered) {
  const auto point = [](double, double) -> Eigen::Vector3d { return {1, 2, 3}; };
  FeaturePlaces a = on_sheet(level, 0.0), b = a;
  a.distances.setZero();
  for (auto& p : a.places) p.position = 100.0 * point(0, 0);
  EXPECT_TRUE(taken_back(a, a).empty());
  taken_back(a, b);  // finite, whatever it is
}

}  // namespace
}  // namespace kinemesh::match_consensus_test
