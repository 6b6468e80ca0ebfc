// Stretches of a trajectory that are another marker's, or nobody's.
#include <gtest/gtest.h>

#include <algorithm>

#include "capture/repair.h"
#include "capture/session.h"
#include "tests/support/data.h"
#include "tests/support/faults.h"

namespace kinemesh::strays_test {
namespace {

MarkerSequence sample(const std::string& name) {
  return read_session(test::sample_folder() / (name + ".c3d"));
}

MarkerSequence real(const std::string& name) {
  return read_session(test::data_folder() / "c3d_face" / (name + ".c3d"));
}

bool same(const Stray& a, const Stray& b) {
  return a.marker == b.marker && a.frames.begin < b.frames.end && b.frames.begin < a.frames.end;
}

TEST(Strays, BetweenTwoGapsAreFoundAndGivenToTheirMarker) {
  const MarkerSequence take = sample("anna_surprise");
  const test::StrayTake put = test::with_strays(take, 16, 9);
  ASSERT_GT(put.strays.size(), 10U);
  const RepairResult mended = repair_take(put.take);
  EXPECT_EQ(mended.strays.size(), put.strays.size());
  EXPECT_TRUE(mended.swaps.empty());
  for (const Stray& stray : put.strays) {
    const auto found = std::ranges::find_if(mended.strays, [&](auto& s) { return same(s, stray); });
    ASSERT_NE(found, mended.strays.end()) << stray.marker << " " << stray.frames.begin;
    EXPECT_EQ(found->owner, stray.owner);
    for (std::size_t f = stray.frames.begin; f < stray.frames.end; ++f) {
      EXPECT_FALSE(mended.take.valid(f, stray.marker));
      if (!stray.owner) continue;
      EXPECT_EQ(mended.take.position(f, *stray.owner), take.position(f, *stray.owner)) << f;
    }
  }
  const EditList list = parse_edits(edits_toml(mended.edits), "edits.toml");
  const MarkerSequence again = apply_edits(put.take, list).take;
  EXPECT_TRUE(std::ranges::equal(again.flags(), mended.take.flags()));
  EXPECT_TRUE(std::ranges::equal(again.positions(), mended.take.positions()));
}

TEST(Strays, NoneInTakesWithoutThem) {
  for (const char* name : {"anna_happy", "anna_surprise", "ben_happy"}) {
    const MarkerSequence take = sample(name);
    EXPECT_TRUE(find_strays(take).empty()) << name;
    for (const uint32_t seed : {1U, 2U}) {
      EXPECT_TRUE(find_strays(test::with_islands(take, 30, seed)).empty()) << name;
    }
  }
}

TEST(Strays, NoneInRealTakesWithoutThem) {
  KINEMESH_NEED_DATA("c3d_face/AnimFace-Jaw.c3d");
  for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows"}) {
    const MarkerSequence take = real(name);
    EXPECT_TRUE(find_strays(take).empty()) << name;
    for (const uint32_t seed : {1U, 2U, 3U}) {
      EXPECT_TRUE(find_strays(test::with_islands(take, 20, seed)).empty()) << name;
    }
  }
}

TEST(Strays, LabelsThatWandersThroughTheBrowsAreMended) {
  KINEMESH_NEED_DATA("c3d_face/Facial-Sing.c3d");
  const MarkerSequence take = real("Facial-Sing");
  const RepairResult mended = repair_take(take);
  // In frame 842 the trajectories of the right brow are on the left one.
  const std::size_t f = 842 - static_cast<std::size_t>(take.first_frame);
  const auto at = [&](const MarkerSequence& t, const char* label) -> Eigen::Vector3f {
    return t.position(f, t.find(label));
  };
  ASSERT_TRUE(mended.take.valid(f, take.find("section4-1")));
  ASSERT_TRUE(mended.take.valid(f, take.find("section4-2")));
  EXPECT_EQ(at(mended.take, "section4-1"), at(take, "section3-2"));
  EXPECT_EQ(at(mended.take, "section4-2"), at(take, "section3-1"));
  EXPECT_FALSE(mended.take.valid(f, take.find("section3-1")));
  EXPECT_FALSE(mended.take.valid(f, take.find("section3-2")));
  for (const Jump& jump : mended.jumps) EXPECT_LT(jump.size_mm, 10.0);
}

}  // namespace
}  // namespace kinemesh::strays_test
