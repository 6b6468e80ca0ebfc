#include "capture/gaps.h"

#include <gtest/gtest.h>

#include <array>

namespace kinemesh::gaps_test {
namespace {

MarkerSequence take_with(std::vector<std::string> patterns) {
  std::vector<Marker> markers;
  for (const std::string& p : patterns) markers.push_back({.label = p});
  MarkerSequence take = MarkerSequence::invalid(patterns.at(0).size(), std::move(markers), 60.0);
  for (std::size_t m = 0; m < patterns.size(); ++m) {
    for (std::size_t f = 0; f < patterns[m].size(); ++f) {
      uint8_t& flags = take.flags()[take.sample(f, m)];
      if (patterns[m][f] == 'x') flags = SampleFlag::valid;
      if (patterns[m][f] == 'f') flags = SampleFlag::valid | SampleFlag::filled;
    }
  }
  return take;
}

TEST(Gaps, AreFoundAtTheEndsAndInTheMiddle) {
  const MarkerSequence take = take_with({"..xx.xxf..", "xxxxxxxxxx", ".........."});
  const auto gaps = find_gaps(take);
  ASSERT_EQ(gaps.size(), 3U);
  EXPECT_EQ(gaps[0].gaps, (std::vector<FrameRange>{{0, 2}, {4, 5}, {7, 10}}));
  EXPECT_EQ(gaps[0].missing, 6U);
  EXPECT_EQ(gaps[0].longest, 3U);
  EXPECT_DOUBLE_EQ(gaps[0].missing_percent, 60.0);
  EXPECT_TRUE(gaps[1].gaps.empty());
  EXPECT_EQ(gaps[2].gaps, (std::vector<FrameRange>{{0, 10}}));
  EXPECT_DOUBLE_EQ(gaps[2].missing_percent, 100.0);
}

TEST(Gaps, FilledSamplesAreUsableButNotMeasured) {
  const MarkerSequence take = take_with({"x.fx"});
  EXPECT_EQ(find_gaps(take, 0, GapKind::unusable).gaps, (std::vector<FrameRange>{{1, 2}}));
  EXPECT_EQ(find_gaps(take, 0).gaps, (std::vector<FrameRange>{{1, 3}}));
}

TEST(Gaps, CompleteFramesHaveEveryMarkerMeasured) {
  const MarkerSequence take = take_with({"xx.x", "xxxf", "...."});
  EXPECT_EQ(complete_frames(take, std::array<std::size_t, 2>{0, 1}),
            (std::vector<std::size_t>{0, 1}));
  EXPECT_TRUE(complete_frames(take, std::array<std::size_t, 1>{2}).empty());
  EXPECT_EQ(complete_frames(take, {}).size(), 4U);
}

TEST(Gaps, ATakeWithoutFramesHasNone) {
  const MarkerSequence take = MarkerSequence::invalid(0, {{.label = "a"}}, 60.0);
  EXPECT_TRUE(find_gaps(take, 0).gaps.empty());
  EXPECT_EQ(find_gaps(take, 0).missing_percent, 0.0);
}

}  // namespace
}  // namespace kinemesh::gaps_test
