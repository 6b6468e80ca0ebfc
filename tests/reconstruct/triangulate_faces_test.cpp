// Generated faces and bodies, whose true surface is known: the figures that the issue demands, on
// a few takes (bench/triangulation_figures measures many).
#include <gtest/gtest.h>
#include <numeric>
#include <random>

#include <algorithm>

#include "capture/gap_fill.h"
#include "capture/marker_selection.h"
#include "reconstruct/carry.h"
#include "reconstruct/triangulate.h"
#include "tests/reconstruct/cloud.h"
#include "tests/support/samples.h"
#include "tests/support/sanitizers.h"
#include "tests/support/synthetic_body.h"
#include "tests/support/triangulation_score.h"

namespace kinemesh::triangulate_faces_test {
namespace {

using test::MotionKind;

void expect_demands(const test::TriangulationScore& score) {
  SCOPED_TRACE(score.summary());
  EXPECT_TRUE(score.manifold && score.all_markers && score.outwards && score.openings_right);
  EXPECT_EQ(score.components, 1U);
  EXPECT_EQ(score.euler, 1 - static_cast<int64_t>(score.openings.size()));
  EXPECT_GE(score.precision, 0.95);
  EXPECT_GE(score.recall, 0.96);
  EXPECT_LE(score.rms_ratio, 1.2);
  EXPECT_LE(score.longest_rim_edge, 2.2);
  for (const auto& opening : score.openings) EXPECT_LE(opening.differing_triangles, 3U);
}

/// Every opening is named as the slit that its markers surround.
void expect_names(const TriangulateResult& result, const test::MarkerLayout& layout) {
  for (const Opening& o : result.openings) {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    for (const VertexIndex v : o.loop)
      centre += layout.domain[v] / static_cast<double>(o.loop.size());
    const std::string_view expected = centre.y() < 0   ? "mouth"
                                      : centre.x() > 0 ? "left eye"
                                                       : "right eye";
    EXPECT_EQ(name_of(o.name), expected);
  }
}

test::SyntheticTake generated(uint64_t seed, double spacing, MotionKind motion) {
  const auto face = test::make_face({seed});
  return test::make_take(face, test::place_markers(*face, spacing, seed), test::make_motion(motion),
                         {.head_degrees = 10, .head_mm = 20, .seed = seed});
}

class GeneratedFaces : public testing::TestWithParam<std::tuple<uint64_t, double, MotionKind>> {};

TEST_P(GeneratedFaces, FulfilTheDemands) {
  const auto [seed, spacing, motion] = GetParam();
  const auto take = generated(seed, spacing, motion);
  const auto result = triangulate(take.measured);
  expect_demands(test::score_triangulation(*result.topology, take.reference_at(result.frame)));
  expect_names(result, take.layout);
}

INSTANTIATE_TEST_SUITE_P(Triangulate, GeneratedFaces,
                         testing::Values(std::tuple{21, 9.0, MotionKind::surprise},
                                         std::tuple{22, 10.0, MotionKind::talk},
                                         std::tuple{23, 8.5, MotionKind::blinks},
                                         std::tuple{24, 9.5, MotionKind::brows},
                                         std::tuple{25, 9.0, MotionKind::pucker}));

TEST(TriangulateFaces, AllFourSamplesFulfilTheDemands) {
  for (const std::string& name : test::sample_names()) {
    if (test::under_sanitizers && name != test::sample_with_swap) continue;
    SCOPED_TRACE(name);
    const auto sample = test::make_sample(name);
    const auto chosen = select_markers(sample.measured).chosen;
    ASSERT_EQ(chosen.size(), sample.face_marker_count());
    const MarkerSequence take = fill_gaps(sample.measured.select(chosen)).take;
    const auto result = triangulate(take);
    expect_demands(test::score_triangulation(*result.topology, sample.reference_at(result.frame)));
    expect_names(result, sample.layout);
    EXPECT_EQ(result.diagnostics.jump_samples > 0, name == test::sample_with_swap);
  }
}

TEST(TriangulateFaces, SameWhateverPoseAndMarkerOrder) {
  const auto take = generated(31, 10.0, MotionKind::surprise);
  const MarkerSequence& markers = take.measured;
  std::vector<std::size_t> order(markers.marker_count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  MarkerSequence moved = markers.select(order);
  const Eigen::Affine3f pose = Eigen::Translation3f(-300, 800, 150) *
                               Eigen::AngleAxisf(2.5F, Eigen::Vector3f(3, -1, 2).normalized());
  for (std::size_t f = 0; f < moved.frame_count(); ++f) {
    for (std::size_t m = 0; m < moved.marker_count(); ++m) {
      moved.position(f, m) = pose * Eigen::Vector3f(moved.position(f, m));
    }
  }
  const auto expected = triangulate(markers);
  const auto found = triangulate(moved);
  const auto named = [](const MarkerSequence& t, std::vector<VertexIndex> loop) {
    std::vector<std::string> labels;
    for (const VertexIndex v : loop) labels.push_back(t.markers()[v].label);
    std::rotate(labels.begin(), std::min_element(labels.begin(), labels.end()), labels.end());
    return labels;
  };
  const auto faces = [&](const MarkerSequence& t, const Topology& topology) {
    std::vector<std::vector<std::string>> list;
    for (const auto& [a, b, c] : topology.faces()) list.push_back(named(t, {a, b, c}));
    std::sort(list.begin(), list.end());
    return list;
  };
  EXPECT_EQ(faces(moved, *found.topology), faces(markers, *expected.topology));
  ASSERT_EQ(found.openings.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(found.openings[i].name, expected.openings[i].name);
    EXPECT_EQ(named(moved, found.openings[i].loop), named(markers, expected.openings[i].loop));
  }
}

TEST(TriangulateFaces, OpeningsAreForcedOnAndOffByName) {
  const auto take = generated(41, 9.0, MotionKind::surprise);
  TriangulateOptions options;
  options.openings.mouth = OpeningMode::closed;
  options.openings.left_eye = OpeningMode::closed;
  auto result = triangulate(take.measured, options);
  ASSERT_EQ(result.openings.size(), 1U);
  EXPECT_EQ(result.openings[0].name, OpeningName::right_eye);
  expect_names(result, take.layout);

  // A smile that hardly parts the lips: asked for by name, the mouth opens nevertheless.
  const auto quiet = generated(41, 9.0, MotionKind::puff);
  EXPECT_TRUE(triangulate(quiet.measured).openings.empty());
  options = {};
  options.openings.mouth = OpeningMode::open;
  result = triangulate(quiet.measured, options);
  ASSERT_EQ(result.openings.size(), 1U);
  EXPECT_TRUE(result.openings[0].forced);
  EXPECT_EQ(result.topology->euler_characteristic(), 0);
}

TEST(TriangulateFaces, JumpsDoNotOpenAnything) {
  auto take = generated(42, 9.0, MotionKind::brows);
  // A marker of the cheek is mistaken for another place for a third of the take.
  const auto cheek = static_cast<std::size_t>(
      std::min_element(take.layout.domain.begin(), take.layout.domain.end(),
                       [](const auto& a, const auto& b) {
                         const Eigen::Vector2d place(42, 0);
                         return (a - place).norm() < (b - place).norm();
                       }) -
      take.layout.domain.begin());
  const std::size_t frames = take.measured.frame_count();
  for (std::size_t f = frames / 3; f < 2 * frames / 3; ++f) {
    take.measured.position(f, cheek) += Eigen::Vector3f(0, -15, 14);
  }
  const auto result = triangulate(take.measured);
  EXPECT_TRUE(result.openings.empty());
  EXPECT_EQ(result.diagnostics.jump_samples, 2 * frames / 3 - frames / 3);
}

TEST(TriangulateFaces, CarriedThroughATakeWithoutFlipsWhereNothingIsWrong) {
  const auto take = generated(43, 9.0, MotionKind::jaw);
  const auto result = triangulate(take.measured);
  const auto carried = carry_topology(result.topology, take.measured, result.frame);
  EXPECT_EQ(carried.quality.size(), take.measured.frame_count());
  EXPECT_EQ(carried.summary.worst_count, 0U);
  EXPECT_GT(carried.summary.stretch_max, 1.1F);
  EXPECT_EQ(carried.summary.filled_samples, 0U);
}

TEST(TriangulateBodies, ClosedAndOpenOnesGiveAMesh) {
  for (const uint64_t seed : {1U, 2U}) {
    const auto closed = test::make_blob(seed);
    const Points on_closed = test::positions_of(closed, test::scatter_markers(closed, 45, seed));
    auto result = triangulate(test::make_take({on_closed}));
    EXPECT_TRUE(result.topology->is_manifold());
    EXPECT_EQ(result.topology->component_count(), 1U);
    EXPECT_EQ(result.topology->isolated_vertex_count(), 0U);
    EXPECT_EQ(result.topology->euler_characteristic(), 2) << on_closed.size();

    const auto open = test::make_open_blob(seed);
    const Points on_open = test::positions_of(open, test::scatter_markers(open, 45, seed));
    result = triangulate(test::make_take({on_open}));
    EXPECT_TRUE(result.topology->is_manifold());
    EXPECT_EQ(result.topology->component_count(), 1U);
    EXPECT_EQ(result.topology->isolated_vertex_count(), 0U);
    EXPECT_EQ(result.topology->euler_characteristic(), 1) << on_open.size();
  }
}

}  // namespace
}  // namespace kinemesh::triangulate_faces_test
