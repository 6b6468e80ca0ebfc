// Real facial takes: what the issue shows on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "capture/gap_fill.h"
#include "capture/marker_selection.h"
#include "capture/session.h"
#include "reconstruct/carry.h"
#include "reconstruct/triangulate.h"
#include "tests/support/data.h"

namespace kinemesh::real_takes_test {
namespace {

/// The chosen markers of a recording, without gaps.
MarkerSequence load(const std::string& name) {
  const MarkerSequence take = read_session(test::data_folder() / "c3d_face" / name);
  return fill_gaps(take.select(select_markers(take).chosen)).take;
}

std::set<std::string> names(const MarkerSequence& take, const std::vector<VertexIndex>& loop) {
  std::set<std::string> labels;
  for (const VertexIndex v : loop) labels.insert(take.markers()[v].label);
  return labels;
}

void expect_sound(const TriangulateResult& result) {
  EXPECT_TRUE(result.topology->is_manifold());
  EXPECT_EQ(result.topology->component_count(), 1U);
  EXPECT_EQ(result.topology->isolated_vertex_count(), 0U);
  EXPECT_EQ(result.topology->euler_characteristic(),
            1 - static_cast<int64_t>(result.openings.size()));
}

void expect_finite(const MarkerSequence& take, const TriangulateResult& result) {
  const auto carried = carry_topology(result.topology, take, result.frame);
  for (const float x : carried.animation.positions()) ASSERT_TRUE(std::isfinite(x));
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (VertexIndex v = 0; v < take.marker_count(); ++v) {
      ASSERT_NE(carried.animation.position(f, v).norm(), 0.0F);
    }
  }
}

TEST(RealTakes, TheMouthOfFacialSingOpensAsARingOfEight) {
  KINEMESH_NEED_DATA("c3d_face/Facial-Sing.c3d");
  const MarkerSequence take = load("Facial-Sing.c3d");
  EXPECT_EQ(take.marker_count(), 31U);
  const auto result = triangulate(take);
  expect_sound(result);
  ASSERT_EQ(result.openings.size(), 1U);
  EXPECT_EQ(result.openings[0].name, OpeningName::mouth);
  EXPECT_EQ(result.openings[0].loop.size(), 8U);
  EXPECT_GT(result.diagnostics.jump_samples, 0U);
  expect_finite(take, result);
}

TEST(RealTakes, TheMouthOfTheJawTakeIsItsEightLipMarkers) {
  KINEMESH_NEED_DATA("c3d_face/AnimFace-Jaw.c3d");
  const MarkerSequence take = load("AnimFace-Jaw.c3d");
  EXPECT_EQ(take.marker_count(), 41U);
  const auto result = triangulate(take);
  expect_sound(result);
  ASSERT_EQ(result.openings.size(), 1U);
  EXPECT_EQ(result.openings[0].name, OpeningName::mouth);
  const std::set<std::string> lips{"Mouth_Up",   "Mouth_Down", "Mouth_UpL1",  "Mouth_UpR1",
                                   "Mouth_Lend", "Mouth_Rend", "Mouth_DownL", "Mouth_DownR"};
  EXPECT_EQ(names(take, result.openings[0].loop), lips);
  expect_finite(take, result);
}

TEST(RealTakes, NothingOpensWhereTheEyebrowsMove) {
  KINEMESH_NEED_DATA("c3d_face/AnimFace-Eyebrows.c3d");
  const MarkerSequence take = load("AnimFace-Eyebrows.c3d");
  const auto result = triangulate(take);
  expect_sound(result);
  EXPECT_TRUE(result.openings.empty());
  expect_finite(take, result);
}

}  // namespace
}  // namespace kinemesh::real_takes_test
