// Labels of three and more markers that go round.
#include <gtest/gtest.h>

#include <random>

#include "capture/repair.h"
#include "capture/session.h"
#include "tests/support/data.h"
#include "tests/support/faults.h"

namespace kinemesh::label_rounds_test {
namespace {

MarkerSequence sample(const std::string& name) {
  return read_session(test::sample_folder() / (name + ".c3d"));
}

std::vector<std::size_t> found(const MarkerSequence& take,
                               std::initializer_list<const char*> names) {
  std::vector<std::size_t> out;
  for (const char* name : names) out.push_back(take.find(name));
  return out;
}

/// Every sample that is left is where the truth has it.
void expect_same(const MarkerSequence& take, const MarkerSequence& truth) {
  std::size_t lost = 0, wrong = 0;
  for (std::size_t f = 0; f < truth.frame_count(); ++f) {
    for (std::size_t m = 0; m < truth.marker_count(); ++m) {
      if (truth.valid(f, m) && !take.valid(f, m)) ++lost;
      if (take.valid(f, m) && (!truth.valid(f, m) || take.position(f, m) != truth.position(f, m))) {
        ++wrong;
      }
    }
  }
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(lost, 0U);
}

TEST(LabelRounds, AreMendedAndTheListDoesTheSame) {
  const MarkerSequence take = sample("ben_happy");
  const auto three = found(take, {"LMOU01", "LMOU02", "LMOU03"});
  const auto four = found(take, {"LCHK04", "LCHK05", "LCHK06", "LCHK07"});
  for (const auto& markers : {three, four}) {
    for (const auto& [from, until] :
         {std::pair<std::size_t, std::size_t>{200, take.frame_count()}, {120, 260}, {150, 156}}) {
      SCOPED_TRACE(std::to_string(markers.size()) + " from " + std::to_string(from));
      MarkerSequence broken = take;
      test::rotate_labels(broken, markers, from, until);
      const RepairResult mended = repair_take(broken);
      const std::size_t times = until < take.frame_count() ? 2 : 1;
      EXPECT_EQ(mended.swaps.size(), times * (markers.size() - 1));
      for (const LabelSwap& swap : mended.swaps) EXPECT_EQ(swap.of, markers.size());
      EXPECT_TRUE(mended.jumps.empty());
      expect_same(mended.take, take);
      const EditList list = parse_edits(edits_toml(mended.edits), "edits.toml");
      expect_same(apply_edits(broken, list).take, take);
    }
  }
}

TEST(LabelRounds, InTheFirstFramesAreMendedThere) {
  const MarkerSequence take = sample("ben_happy");
  MarkerSequence broken = take;
  test::rotate_labels(broken, found(take, {"LCHK04", "LCHK05", "LCHK06", "LCHK07"}), 0, 6);
  const RepairResult mended = repair_take(broken);
  ASSERT_EQ(mended.swaps.size(), 3U);
  EXPECT_EQ(mended.swaps[0].from, 0U);
  EXPECT_EQ(mended.swaps[0].until, 6U);
  expect_same(mended.take, take);
}

TEST(LabelRounds, BeginBehindAGap) {
  const MarkerSequence take = sample("ben_happy");
  const auto markers = found(take, {"LMOU01", "LMOU02", "LMOU03"});
  MarkerSequence truth = take;
  const std::size_t back[] = {212, 215, 209};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t f = 200; f < back[i]; ++f) truth.flags()[truth.sample(f, markers[i])] = 0;
  }
  MarkerSequence broken = truth;
  test::rotate_labels(broken, markers, 200, truth.frame_count());
  expect_same(repair_take(broken).take, truth);
}

}  // namespace
}  // namespace kinemesh::label_rounds_test
