// Spikes at known places: near a take's ends, close together, many; and what they do to labels.
#include <gtest/gtest.h>

#include "capture/repair.h"
#include "capture/session.h"
#include "tests/support/data.h"
#include "tests/support/faults.h"

namespace kinemesh::spikes_test {
namespace {

MarkerSequence sample(const std::string& name) {
  return read_session(test::sample_folder() / (name + ".c3d"));
}

TEST(Spikes, InTheFirstAndLastFramesAreFound) {
  const MarkerSequence take = sample("anna_surprise");
  const std::size_t last = take.frame_count() - 1;
  for (const std::size_t f : {std::size_t{1}, std::size_t{2}, last - 1, last - 2}) {
    for (const std::size_t m : {std::size_t{7}, std::size_t{60}, std::size_t{120}}) {
      SCOPED_TRACE(std::to_string(m) + " in " + std::to_string(f));
      MarkerSequence spiky = take;
      ASSERT_TRUE(spiky.valid(f, m));
      spiky.position(f, m) += Eigen::Vector3f(3.0F, -4.0F, 2.0F);
      const auto found = find_spikes(spiky);
      ASSERT_EQ(found.size(), 1U);
      EXPECT_EQ(found[0].marker, m);
      EXPECT_EQ(found[0].frames, (FrameRange{f, f + 1}));
    }
  }
}

TEST(Spikes, BesideOneAnotherAreFoundWithTheirFrames) {
  MarkerSequence take = sample("anna_surprise");
  const std::size_t m = 60;
  const std::vector<FrameRange> put{{100, 102}, {104, 105}};
  float sign = 1.0F;
  for (const FrameRange& frames : put) {
    for (std::size_t f = frames.begin; f < frames.end; ++f) take.position(f, m).x() += sign * 9.0F;
    sign = -sign;
  }
  const auto found = find_spikes(take);
  ASSERT_EQ(found.size(), put.size());
  for (std::size_t i = 0; i < put.size(); ++i) EXPECT_EQ(found[i].frames, put[i]);
}

TEST(Spikes, ManyAreFoundAndTakenForNoExchange) {
  const MarkerSequence take = sample("ben_happy");
  const test::SpikyTake spiky = test::with_spikes(take, 0.01, 3);
  EXPECT_GT(spiky.spikes.size(), 300U);
  const RepairResult mended = repair_take(spiky.take);
  EXPECT_LE(test::not_among(spiky.spikes, mended.spikes), spiky.spikes.size() / 100);
  EXPECT_EQ(test::not_among(mended.spikes, spiky.spikes), 0U);
  EXPECT_TRUE(mended.swaps.empty());
  const EditList again = parse_edits(edits_toml(mended.edits), "edits.toml");
  EXPECT_TRUE(std::ranges::equal(apply_edits(spiky.take, again).take.flags(), mended.take.flags()));
}

TEST(Spikes, ASwapAmongThemIsStillFoundInItsFrame) {
  const test::SpikyTake spiky = test::with_spikes(sample("ben_surprise"), 0.005, 4);
  const RepairResult mended = repair_take(spiky.take);
  ASSERT_EQ(mended.swaps.size(), 1U);
  EXPECT_EQ(mended.swaps[0].from, 243U);
}

TEST(Spikes, ManyInRealTakes) {
  KINEMESH_NEED_DATA("c3d_face/AnimFace-Jaw.c3d");
  for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows"}) {
    SCOPED_TRACE(name);
    const MarkerSequence take =
        read_session(test::data_folder() / "c3d_face" / (std::string(name) + ".c3d"));
    const test::SpikyTake spiky = test::with_spikes(take, 0.01, 5);
    const RepairResult mended = repair_take(spiky.take);
    EXPECT_LE(test::not_among(spiky.spikes, mended.spikes), spiky.spikes.size() / 100);
    EXPECT_EQ(test::not_among(mended.spikes, spiky.spikes), 0U);
    EXPECT_TRUE(mended.swaps.empty());
  }
}

}  // namespace
}  // namespace kinemesh::spikes_test
