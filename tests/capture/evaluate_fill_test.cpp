#include "capture/evaluate_fill.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/session.h"
#include "config/error.h"
#include "tests/support/data.h"

namespace kinemesh::evaluate_fill_test {
namespace {

/// Markers that move together on a slow curve, each by its own factor.
MarkerSequence waving(std::size_t frames, std::size_t markers) {
  std::vector<Marker> names(markers);
  for (std::size_t m = 0; m < markers; ++m) names[m].label = "m" + std::to_string(m);
  MarkerSequence take(frames, names, 100.0);
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = static_cast<double>(f) / 100.0;
    for (std::size_t m = 0; m < markers; ++m) {
      const auto k = static_cast<double>(m);
      const Eigen::Vector3d p(30.0 * k + std::sin(3.0 * t),
                              10.0 * std::cos(k) + k * std::sin(2 * t),
                              900.0 + 0.5 * k * std::cos(5.0 * t));
      take.position(f, m) = p.cast<float>();
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
      take.residuals()[take.sample(f, m)] = 0.0F;
      take.camera_masks()[take.sample(f, m)] = 0;
    }
  }
  return take;
}

TEST(EvaluateFill, ScoresEveryMethodOnTheSameGaps) {
  const MarkerSequence take = waving(300, 8);
  const auto result = evaluate_fill(take, {.markers = 3, .gap_s = 0.2, .trials = 4});
  EXPECT_EQ(result.gap_frames, 20U);
  EXPECT_EQ(result.candidates, 8U);
  ASSERT_EQ(result.scores.size(), 7U);
  for (const FillScore& s : result.scores) {
    EXPECT_EQ(s.gaps + s.not_filled, 12U) << name_of(s.method);
    EXPECT_LE(s.median_mm, s.percentile_90_mm);
    EXPECT_LE(s.percentile_90_mm, s.maximum_mm);
  }
  EXPECT_LT(result.scores[0].median_mm, 0.05);
  EXPECT_TRUE(std::isfinite(result.scores[0].within_band_percent));
  EXPECT_TRUE(std::isnan(result.scores[1].within_band_percent));
  EXPECT_GT(result.scores[1].median_mm, result.scores[2].median_mm);
}

TEST(EvaluateFill, TheSeedAloneDecides) {
  const MarkerSequence take = waving(200, 6);
  const EvaluateFillOptions options{
      .markers = 2, .gap_s = 0.1, .trials = 3, .noise_mm = 0.1, .methods = {"cubic", "auto"}};
  const auto a = evaluate_fill(take, options, RunContext().set_seed(3).set_threads(1));
  const auto b = evaluate_fill(take, options, RunContext().set_seed(3).set_threads(3));
  const auto c = evaluate_fill(take, options, RunContext().set_seed(4));
  EXPECT_EQ(a.scores[0].median_mm, b.scores[0].median_mm);
  EXPECT_EQ(a.scores[1].median_mm, b.scores[1].median_mm);
  EXPECT_NE(a.scores[0].median_mm, c.scores[0].median_mm);
}

TEST(EvaluateFill, ExchangedLabelsDoNotStandForTheTruth) {
  const MarkerSequence take = read_session(test::sample_folder() / "ben_surprise.c3d");
  const EvaluateFillOptions options{.trials = 1, .methods = {"linear"}};
  const auto result = evaluate_fill(take, options);
  ASSERT_FALSE(result.repaired.empty());
  EXPECT_NE(result.repaired.front().find("RCHN01"), std::string::npos);
  EXPECT_NE(evaluate_fill_text(result).find("first: exchanged"), std::string::npos);
  EXPECT_TRUE(
      evaluate_fill(take, {.trials = 1, .repair = false, .methods = {"linear"}}).repaired.empty());
}

TEST(EvaluateFill, WhatSomebodyFilledIsNoTruth) {
  MarkerSequence take = waving(100, 4);
  for (std::size_t f = 40; f < 60; ++f) {
    take.flags()[take.sample(f, 1)] = SampleFlag::valid | SampleFlag::filled;
  }
  const auto result =
      evaluate_fill(take, {.markers = 3, .gap_s = 0.5, .trials = 1, .methods = {"linear"}});
  EXPECT_EQ(result.candidates, 3U);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("20 samples were filled"), std::string::npos);
}

TEST(EvaluateFill, SaysWhatIsImpossible) {
  const MarkerSequence take = waving(50, 3);
  EXPECT_THROW(evaluate_fill(take, {.markers = 2, .gap_s = 2.0}), NoResultError);
  EXPECT_THROW(evaluate_fill(take, {.markers = 4, .gap_s = 0.1}), NoResultError);
  EXPECT_THROW(evaluate_fill(take, {.methods = {"magic"}}), UsageError);
  EXPECT_THROW(evaluate_fill(take, {.trials = 0}), UsageError);
}

}  // namespace
}  // namespace kinemesh::evaluate_fill_test
