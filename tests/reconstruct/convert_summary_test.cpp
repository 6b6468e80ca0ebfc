// What the summary of a conversion calls doubtful.
#include "reconstruct/convert_summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/reconstruct/cloud.h"

namespace kinemesh::convert_summary_test {
namespace {

using test::cap;
using test::make_take;
using test::scatter;

/// Markers that move a little over 200 frames at 100 Hz.
MarkerSequence moving_cap() {
  const Points rest = scatter(cap(60, 1.3), 12, 4);
  std::vector<Points> frames;
  for (int f = 0; f < 200; ++f) {
    frames.push_back(rest);
    for (Eigen::Vector3d& p : frames.back()) p.z() += 0.5 * std::sin(0.05 * f + 0.1 * p.x());
  }
  return make_take(frames);
}

void hide(MarkerSequence& take, std::size_t first_marker, std::size_t begin, std::size_t end) {
  for (std::size_t f = begin; f < end; ++f) {
    for (std::size_t m = first_marker; m < take.marker_count(); ++m) {
      take.flags()[take.sample(f, m)] = 0;
    }
  }
}

ConvertResult converted(const MarkerSequence& take) {
  ConvertOptions options;
  options.gaps.method = FillMethod::linear;
  return convert_session(take, options);
}

std::size_t with(const std::vector<std::string>& doubts, std::string_view part) {
  return static_cast<std::size_t>(std::ranges::count_if(
      doubts, [&](const std::string& d) { return d.find(part) != std::string::npos; }));
}

TEST(ConvertSummary, AStretchWithoutAnyMarkerIsOneSentence) {
  MarkerSequence take = moving_cap();
  hide(take, 0, 50, 100);
  const auto doubts = doubts_of(converted(take));
  EXPECT_EQ(with(doubts, "no marker at all is seen in frames 51 to 100 (0.50 s)"), 1U);
  const std::string all = std::to_string(take.marker_count());
  EXPECT_EQ(with(doubts, all + " markers of " + all + " are missing in more than 20 % of"), 1U);
  EXPECT_EQ(with(doubts, "marker '"), 0U);
}

TEST(ConvertSummary, AFewMarkersThatAreMissingForLongAreNamed) {
  MarkerSequence take = moving_cap();
  hide(take, take.marker_count() - 3, 50, 100);
  const auto doubts = doubts_of(converted(take));
  EXPECT_EQ(with(doubts, "is missing in 25 % of the frames, up to 0.5 s at a time"), 3U);
  EXPECT_EQ(with(doubts, "no marker at all"), 0U);
}

TEST(ConvertSummary, HalfAnEyeIsDoubtful) {
  ConvertResult result = converted(moving_cap());
  result.triangulation.openings = {
      {OpeningName::left_eye, {0, 1, 2, 3, 4}, 5.0, false},
      {OpeningName::right_eye, {10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20}, 5.0, false}};
  EXPECT_EQ(with(doubts_of(result), "the ring of the left eye has only 5 markers"), 1U);
  result.triangulation.openings[0].loop = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  EXPECT_EQ(with(doubts_of(result), "the ring of"), 0U);
}

}  // namespace
}  // namespace kinemesh::convert_summary_test
