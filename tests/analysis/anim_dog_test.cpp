// The detector on generated motion whose features are known.
#include "analysis/anim_dog.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "analysis/feature_io.h"
#include "config/error.h"
#include "tests/support/deforming_shapes.h"
#include "tests/support/sanitizers.h"

namespace kinemesh::anim_dog_test {
namespace {

using test::Bump;
using test::make_sheet;

/// A Gaussian blob in space and time as the scalar itself.
VertexCurves blob_scalar(const test::Sheet& sheet, std::size_t frames, const Eigen::Vector2d& at,
                         double sigma, double frame, double tau) {
  VertexCurves scalar(sheet.positions.size(), frames);
  for (std::size_t v = 0; v < sheet.positions.size(); ++v) {
    const double r = (sheet.positions[v].head<2>() - at).norm() / sigma;
    for (std::size_t f = 0; f < frames; ++f) {
      const double s = (static_cast<double>(f) - frame) / tau;
      scalar.of(v)[f] = static_cast<float>(std::exp(-0.5 * r * r - 0.5 * s * s));
    }
  }
  return scalar;
}

TEST(AnimDog, ABlobIsFoundAtItsPlaceAndMoment) {
  const auto sheet = make_sheet(200, 200, 4, 1);
  const auto mesh = test::animate(
      sheet.topology, std::vector<std::vector<Eigen::Vector3d>>(60, sheet.positions), 60);
  const auto rest = deformation_of(mesh);
  for (const SpatialFilter filter : {SpatialFilter::cotangent, SpatialFilter::ring}) {
    DetectOptions options;
    options.filter = filter;
    options.smoothings = 60;
    options.time_smoothings = 40;
    const auto scalar = blob_scalar(sheet, 60, {90, 120}, 12, 25, 3);
    const auto found = detect_in_scalar(mesh, rest, scalar, options);
    ASSERT_FALSE(found.set.features.empty());
    const Feature& f = found.set.features[0];
    EXPECT_LT((sheet.positions[f.vertex].head<2>() - Eigen::Vector2d(90, 120)).norm(), 6.0);
    EXPECT_NEAR(f.frame, 25, 1);
    EXPECT_NEAR(f.time_s, f.frame / 60.0, 1e-12);
  }
}

TEST(AnimDog, LargerBlobsHaveLargerScales) {
  KINEMESH_LEAVE_TO_RELEASE("ABlobIsFoundAtItsPlaceAndMoment");
  const auto sheet = make_sheet(240, 240, 5, 2);
  const auto mesh = test::animate(
      sheet.topology, std::vector<std::vector<Eigen::Vector3d>>(80, sheet.positions), 60);
  const auto rest = deformation_of(mesh);
  DetectOptions options;
  options.sigma_levels = 8;
  options.tau_levels = 8;
  const auto small =
      detect_in_scalar(mesh, rest, blob_scalar(sheet, 80, {120, 120}, 10, 40, 3), options);
  const auto large =
      detect_in_scalar(mesh, rest, blob_scalar(sheet, 80, {120, 120}, 24, 40, 9), options);
  ASSERT_FALSE(small.set.features.empty());
  ASSERT_FALSE(large.set.features.empty());
  EXPECT_LT(small.set.features[0].sigma_mm, large.set.features[0].sigma_mm);
  EXPECT_LT(small.set.features[0].tau_s, large.set.features[0].tau_s);
}

TEST(AnimDog, TilesThreadsAndOrderGiveTheSameFeatures) {
  const auto sheet = make_sheet(150, 150, 3, 3);
  const auto mesh =
      test::bumps(sheet, {{{40, 40}, 12, 0.3, 0.06, 8}, {{110, 90}, 20, 0.6, 0.1, 12}}, 1, 40);
  const auto deformation = deformation_of(mesh);
  DetectOptions options;
  const auto whole = detect_features(mesh, deformation, options, RunContext().set_threads(1));
  options.memory_mb = 10.0;
  options.sigma_levels = 40;  // more than fit at once
  options.step = 1.05;
  const auto tiled = detect_features(mesh, deformation, options, RunContext().set_threads(2));
  EXPECT_GT(tiled.tiles, 1U);
  EXPECT_LE(tiled.level_bytes, 12'000'000U);
  options.memory_mb = 1000.0;
  const auto once = detect_features(mesh, deformation, options, RunContext().set_threads(1));
  EXPECT_EQ(once.tiles, 1U);
  EXPECT_EQ(features_json(once.set), features_json(tiled.set));
  EXPECT_FALSE(whole.set.features.empty());
}

TEST(AnimDog, EveryFeatureIsAStrictMinimumInSpaceTimeAndScale) {
  // Against a plain evaluation of the definition on a small mesh.
  const auto sheet = make_sheet(60, 60, 5, 4);
  const auto mesh =
      test::bumps(sheet, {{{20, 30}, 8, 0.4, 0.08, 5}, {{42, 25}, 10, 0.7, 0.1, 6}}, 1, 24);
  DeformationOptions deformation_options;
  DetectOptions options;
  set_thesis_preset(deformation_options, options);
  options.smoothings = 12;
  options.time_smoothings = 10;
  options.threshold = 0.0;
  const auto deformation = deformation_of(mesh, deformation_options);
  const auto found = detect_features(mesh, deformation, options);
  // L(k, l) by repeated averages, in double.
  const std::size_t n = mesh.vertex_count(), frames = 24, levels = 13, times = 11;
  const auto at = [&](std::size_t v, std::size_t f) { return v * frames + f; };
  std::vector<std::vector<std::vector<double>>> level(levels);
  std::vector<double> now(n * frames);
  for (std::size_t v = 0; v < n; ++v) {
    for (std::size_t f = 0; f < frames; ++f) now[at(v, f)] = deformation.values.of(v)[f];
  }
  for (std::size_t k = 0; k < levels; ++k) {
    std::vector<double> in_time = now;
    for (std::size_t l = 0; l < times; ++l) {
      level[k].push_back(in_time);
      std::vector<double> next(in_time.size());
      for (std::size_t v = 0; v < n; ++v) {
        for (std::size_t f = 0; f < frames; ++f) {
          const std::size_t before = f > 0 ? f - 1 : 0, after = std::min(f + 1, frames - 1);
          next[at(v, f)] =
              (in_time[at(v, before)] + in_time[at(v, f)] + in_time[at(v, after)]) / 3.0;
        }
      }
      in_time = next;
    }
    std::vector<double> next = now;
    for (std::size_t v = 0; v < n; ++v) {
      const auto ring = mesh.topology().neighbours_of(static_cast<VertexIndex>(v));
      for (std::size_t f = 0; f < frames; ++f) {
        double sum = now[at(v, f)];
        for (const VertexIndex u : ring) sum += now[at(u, f)];
        next[at(v, f)] = sum / static_cast<double>(ring.size() + 1);
      }
    }
    now = next;
  }
  const double edge = deformation.mean_edge_mm;
  const auto d = [&](std::size_t v, std::size_t f, std::size_t k, std::size_t l) {
    const double sigma = found.sigmas_mm[k] / edge, tau = std::sqrt(2.0 / 3.0 * l);
    const double here = level[k][l][at(v, f)];
    return sigma * sigma * std::sqrt(tau) * (level[k + 1][l][at(v, f)] - here) +
           sigma * std::pow(tau, 1.5) * (level[k][l + 1][at(v, f)] - here);
  };
  // What rounding decides is left out: responses below a thousandth of the strongest.
  ASSERT_FALSE(found.set.features.empty());
  const double least = 1e-3 * found.set.features[0].response;
  const auto strong = std::count_if(found.set.features.begin(), found.set.features.end(),
                                    [&](const Feature& f) { return f.response > least; });
  std::ptrdiff_t expected = 0, agreeing = 0;
  for (std::size_t v = 0; v < n; ++v) {
    auto places = std::vector<std::size_t>{v};
    for (const VertexIndex u : mesh.topology().neighbours_of(static_cast<VertexIndex>(v))) {
      places.push_back(u);
    }
    for (std::size_t f = 0; f < frames; ++f) {
      for (std::size_t k = 1; k + 2 < levels; ++k) {
        for (std::size_t l = 1; l + 2 < times; ++l) {
          const double here = d(v, f, k, l);
          bool lowest = here < -least;
          for (const std::size_t u : places) {
            for (std::size_t g = f > 0 ? f - 1 : 0; lowest && g <= std::min(f + 1, frames - 1);
                 ++g) {
              lowest = (u == v && g == f) || d(u, g, k, l) > here;
            }
          }
          for (std::size_t kk = k - 1; lowest && kk <= k + 1; ++kk) {
            for (std::size_t ll = l - 1; lowest && ll <= l + 1; ++ll) {
              lowest = (kk == k && ll == l) || d(v, f, kk, ll) > here;
            }
          }
          if (!lowest) continue;
          ++expected;
          for (const Feature& feature : found.set.features) {
            if (feature.vertex == v && feature.frame == f &&
                std::abs(feature.response + here) < 1e-3 * std::abs(here) + 1e-6) {
              ++agreeing;
              break;
            }
          }
        }
      }
    }
  }
  EXPECT_GT(expected, 0);
  EXPECT_EQ(agreeing, expected);
  EXPECT_EQ(strong, expected);
}

TEST(AnimDog, TooFewFramesAndNoDeformationSayWhy) {
  const auto sheet = make_sheet(40, 40, 4, 5);
  const auto one = test::animate(sheet.topology, {sheet.positions}, 30);
  const auto none = detect_features(one, deformation_of(one));
  EXPECT_TRUE(none.set.features.empty());
  EXPECT_NE(none.empty_reason.find("1 frame"), std::string::npos);
  const auto still = test::animate(
      sheet.topology, std::vector<std::vector<Eigen::Vector3d>>(20, sheet.positions), 30);
  const auto nothing = detect_features(still, deformation_of(still));
  EXPECT_TRUE(nothing.set.features.empty());
  EXPECT_NE(nothing.empty_reason.find("nothing deforms"), std::string::npos);
  EXPECT_THROW(detect_features(one, deformation_of(still)), UsageError);
}

TEST(AnimDog, AJumpIsNoCrash) {
  const auto sheet = make_sheet(40, 40, 4, 6);
  std::vector<std::vector<Eigen::Vector3d>> frames(20, sheet.positions);
  for (Eigen::Vector3d& p : frames[10]) p = 1e6 * Eigen::Vector3d::Random();
  const auto mesh = test::animate(sheet.topology, frames, 30);
  for (const Feature& f : detect_features(mesh, deformation_of(mesh)).set.features) {
    EXPECT_TRUE(std::isfinite(f.response));
  }
}

TEST(AnimDog, DisplacementFeaturesAreTheTips) {
  const auto sheet = make_sheet(100, 100, 4, 7);
  const auto mesh =
      test::bumps(sheet, {{{30, 30}, 10, 0.5, 0.1, 9}, {{70, 60}, 12, 0.5, 0.1, 14}}, 1, 30);
  const auto features = displacement_features(mesh, deformation_of(mesh));
  ASSERT_EQ(features.size(), 2U);
  EXPECT_EQ(features[0].kind, FeatureKind::displacement);
  EXPECT_EQ(features[0].response, 1.0);
  EXPECT_LT((sheet.positions[features[0].vertex].head<2>() - Eigen::Vector2d(70, 60)).norm(), 4);
  EXPECT_LT((sheet.positions[features[1].vertex].head<2>() - Eigen::Vector2d(30, 30)).norm(), 4);
  EXPECT_NEAR(features[1].response, 9.0 / 14.0, 0.05);
}

}  // namespace
}  // namespace kinemesh::anim_dog_test
