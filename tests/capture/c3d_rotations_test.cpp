#include "capture/c3d/rotations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "capture/c3d/check.h"
#include "capture/c3d/header_block.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/repair.h"
#include "capture/c3d/writer.h"
#include "capture/session_diff.h"
#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::c3d_rotations_test {
namespace {

using test::has_finding;
using test::read_encoded;

/// A take with `count` rotations, two samples a frame; the last one of each was not measured.
MarkerSequence rotating_take(std::size_t frames, std::size_t markers, std::size_t count = 3) {
  MarkerSequence take = test::make_take(frames, markers);
  take.rotations.count = count;
  take.rotations.samples_per_frame = 2;
  take.rotations.values = Buffer<float>(frames * 2 * count * 17);
  for (std::size_t i = 0; i < take.rotations.values.size(); ++i) {
    const bool reliability = i % 17 == 16;
    const bool last = i / 17 % count == count - 1;
    take.rotations.values[i] =
        reliability ? (last ? -1.0F : 1.0F) : static_cast<float>(i % 1001) * 0.0625F - 20.0F;
  }
  take.parameters.set("ROTATION", texts_parameter("LABELS", {"pelvis", "thigh", "shank"}));
  return take;
}

bool same_rotations(const RotationData& a, const RotationData& b) {
  return a.count == b.count && a.samples_per_frame == b.samples_per_frame &&
         std::ranges::equal(a.values.span(), b.values.span());
}

TEST(C3dRotations, SurviveARoundTripInEveryVariant) {
  const MarkerSequence take = rotating_take(40, 5);
  for (const char* processor : {"intel", "dec", "sgi"}) {
    for (const char* storage : {"int", "float"}) {
      SCOPED_TRACE(std::string(processor) + " " + storage);
      const C3dReadResult r =
          read_encoded(encode_c3d(take, {.processor = processor, .storage = storage}));
      EXPECT_FALSE(has_errors(r.findings));
      EXPECT_TRUE(has_finding(r, "C3D315"));
      EXPECT_TRUE(same_rotations(take.rotations, r.take.rotations));
      EXPECT_EQ(r.take.frame_count(), 40U);
      const std::string again = encode_c3d(r.take);
      EXPECT_EQ(again, encode_c3d(read_encoded(again).take));
      EXPECT_TRUE(diff_sessions(r.take, read_encoded(again).take).identical());
    }
  }
}

TEST(C3dRotations, AreReadWithoutAnyPoints) {
  MarkerSequence take = rotating_take(30, 0);
  const C3dReadResult r = read_encoded(encode_c3d(take));
  EXPECT_FALSE(has_errors(r.findings));
  EXPECT_EQ(r.take.frame_count(), 30U);
  EXPECT_EQ(r.take.marker_count(), 0U);
  EXPECT_TRUE(same_rotations(take.rotations, r.take.rotations));
}

TEST(C3dRotations, TheRateStandsInForTheRatio) {
  MarkerSequence take = rotating_take(20, 4);
  take.parameters.set("ROTATION", real_parameter("RATE", {1.0}));
  const C3dReadResult r = read_encoded(encode_c3d(take));
  EXPECT_EQ(first_number(r.take.parameters, "ROTATION", "RATE"), 200.0);
  EXPECT_EQ(r.take.parameters.find("ROTATION", "RATIO"), nullptr);
  EXPECT_TRUE(same_rotations(take.rotations, r.take.rotations));
}

TEST(C3dRotations, CountsThatSaturatedDoNotCountRotationsAsFrames) {
  MarkerSequence take = rotating_take(30, 4);
  std::string bytes = encode_c3d(take);
  std::memcpy(bytes.data() + 8, "\xFF\xFF", 2);  // last frame
  const std::size_t at = test::place_of(bytes, "POINT", "FRAMES");
  std::memcpy(bytes.data() + at, "\xFF\xFF", 2);
  const C3dReadResult r = read_encoded(bytes);
  // The block's padding may hold zero frames; rotations are 24 blocks more.
  EXPECT_GE(r.take.frame_count(), 30U);
  EXPECT_LE(r.take.frame_count(), 38U);
}

TEST(C3dRotations, C3D319CutOffOnesAreMarkedByTheRepair) {
  const MarkerSequence take = rotating_take(40, 5);
  const std::string whole = encode_c3d(take);
  const std::size_t behind = 40 * 2 * 3 * rotation_bytes;
  const std::size_t begin = whole.size() - (behind + c3d_block - 1) / c3d_block * c3d_block;
  const std::string cut = whole.substr(0, begin + 30 * 2 * 3 * rotation_bytes + 100);
  const C3dReadResult r = read_encoded(cut);
  EXPECT_TRUE(has_finding(r, "C3D319"));
  EXPECT_TRUE(has_errors(r.findings));
  const std::size_t kept = std::size_t{30} * 2 * 3 * 17;
  EXPECT_TRUE(std::equal(take.rotations.values.begin(), take.rotations.values.begin() + kept,
                         r.take.rotations.values.begin()));
  EXPECT_EQ(r.take.rotations.values[kept + 16], -1.0F);
  C3dRepairResult repair;
  const std::string repaired = repaired_bytes(cut, "cut.c3d", {}, repair);
  const C3dReadResult after = read_encoded(repaired);
  EXPECT_FALSE(has_errors(after.findings));
  EXPECT_EQ(repair.changed, 0U);
  EXPECT_TRUE(same_rotations(r.take.rotations, after.take.rotations));
}

TEST(C3dRotations, C3D319PointersIntoThePointsAreNotFollowed) {
  std::string bytes = encode_c3d(rotating_take(40, 5));
  const C3dReadResult sound = read_encoded(bytes);
  const auto block = static_cast<char>(sound.layout.data_begin / c3d_block + 1);
  bytes[test::place_of(bytes, "ROTATION", "DATA_START")] = block;
  bytes[test::place_of(bytes, "ROTATION", "DATA_START") + 1] = 0;
  const C3dReadResult r = read_encoded(bytes);
  EXPECT_TRUE(has_finding(r, "C3D319"));
  EXPECT_TRUE(r.take.rotations.values.empty());
  EXPECT_EQ(r.take.frame_count(), 40U);
  C3dRepairResult repair;
  EXPECT_FALSE(has_errors(read_encoded(repaired_bytes(bytes, "b.c3d", {}, repair)).findings));
  EXPECT_EQ(repair.changed, 0U);
}

TEST(C3dRotations, DifferencesAndLossesAreNamed) {
  const MarkerSequence take = rotating_take(40, 5);
  MarkerSequence other = take;
  other.rotations.values[17 * 3 * 2 * 4 + 17 + 12] += 1.5F;
  const SessionDiffResult diff = diff_sessions(take, other);
  ASSERT_EQ(diff.differences.size(), 1U);
  EXPECT_EQ(diff.differences[0].kind, DifferenceKind::rotation);
  EXPECT_EQ(diff.differences[0].place, "rotation 2");
  EXPECT_EQ(diff.differences[0].frame, 5);
  EXPECT_NEAR(diff.differences[0].largest, 1.5, 1e-6);
  // A take that lost its rotations on the way says so before it is written.
  MarkerSequence without = read_encoded(encode_c3d(take)).take;
  without.rotations = {};
  const std::vector<C3dLoss> losses = c3d_losses(without);
  EXPECT_TRUE(std::ranges::any_of(
      losses, [](const C3dLoss& l) { return l.place == "parameter ROTATION:USED"; }));
  EXPECT_TRUE(read_encoded(encode_c3d(without)).take.rotations.values.empty());
  without.rotations.count = 1;
  without.rotations.samples_per_frame = 1;
  EXPECT_THROW(c3d_losses(without), UsageError);
}

TEST(C3dRotations, Ezc3dReadsThemAlike) {
  const test::TemporaryFolder folder;
  for (const char* storage : {"int", "float"}) {
    write_file(folder.path() / "r.c3d", encode_c3d(rotating_take(40, 5), {.storage = storage}));
    const C3dCheckResult result = check_session(folder.path() / "r.c3d");
    EXPECT_EQ(result.second_opinion, SecondOpinion::agrees) << check_text(result);
  }
}

}  // namespace
}  // namespace kinemesh::c3d_rotations_test
