#include "analysis/feature_alignment.h"

#include <gtest/gtest.h>

namespace kinemesh::feature_alignment_test {
namespace {

FeatureSet set_of(const std::vector<std::pair<uint32_t, double>>& frames_and_sigmas) {
  FeatureSet set{
      .animation = "a", .vertex_count = 100, .frame_count = 101, .rate_hz = 50, .diagonal_mm = 100};
  for (const auto& [frame, sigma] : frames_and_sigmas) {
    set.features.push_back(
        {.vertex = frame, .frame = frame, .time_s = frame / 50.0, .sigma_mm = sigma, .tau_s = 0.1});
  }
  return set;
}

TEST(FeatureAlignment, ASequenceIsLikeItself) {
  const FeatureSet a = set_of({{40, 3}, {10, 2}, {70, 9}});
  const FeatureAlignment result = align_features(a, a);
  ASSERT_EQ(result.pairs.size(), 3U);
  EXPECT_EQ(result.pairs[0].a, 1U);  // in the order of time
  for (const auto& pair : result.pairs) EXPECT_EQ(pair.a, pair.b);
  EXPECT_EQ(result.similarity, 1.0);
}

TEST(FeatureAlignment, OneThatIsMissingIsAGap) {
  const FeatureSet a = set_of({{10, 2}, {20, 9}, {30, 30}, {40, 4}});
  const FeatureSet b = set_of({{15, 2}, {45, 30}, {60, 4}});
  const FeatureAlignment result = align_features(a, b);
  EXPECT_EQ(result.pairs.size(), 3U);
  EXPECT_EQ(result.only_a, std::vector<std::size_t>{1});
  EXPECT_TRUE(result.only_b.empty());
  EXPECT_DOUBLE_EQ(result.gap_cost, 0.5);
  // All without counterpart: (0.5 + 3 × 0.3) + (0.5 + 2 × 0.3).
  EXPECT_NEAR(result.similarity, 1.0 - 0.5 / 2.5, 1e-12);
}

TEST(FeatureAlignment, ARunOfGapsCostsLessThanGapsApart) {
  // The two small features may stay alone together (0.8) or apart (1.0).
  const FeatureSet a = set_of({{10, 1}, {20, 1}, {30, 100}});
  const FeatureSet b = set_of({{30, 100}});
  const FeatureAlignment result = align_features(a, b);
  EXPECT_EQ(result.pairs.size(), 1U);
  EXPECT_DOUBLE_EQ(result.gap_cost, 0.8);
}

TEST(FeatureAlignment, NothingInCommonAndNothingAtAll) {
  EXPECT_NEAR(align_features(set_of({{10, 0.001}}), set_of({{10, 1000}})).similarity, 0.0, 1e-12);
  EXPECT_EQ(align_features(set_of({}), set_of({})).similarity, 1.0);
  EXPECT_EQ(align_features(set_of({{1, 1}}), set_of({})).similarity, 0.0);
}

}  // namespace
}  // namespace kinemesh::feature_alignment_test
