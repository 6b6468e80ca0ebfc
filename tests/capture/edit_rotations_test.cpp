// Rotations of segments go along when a take is edited.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "capture/c3d/writer.h"
#include "capture/edit/timeline.h"
#include "capture/edit_list.h"
#include "capture/rotation_data.h"
#include "capture/stabilise.h"
#include "tests/support/c3d_takes.h"

namespace kinemesh::edit_rotations_test {
namespace {

constexpr std::size_t rotations = 2, samples = 2, floats = 17;

/// Numbers that say where they belong; the second rotation was not measured.
MarkerSequence turning_take(std::size_t frames) {
  MarkerSequence take = test::make_take(frames, 4);
  take.rotations = {rotations, samples, Buffer<float>(frames * rotations * samples * floats)};
  for (std::size_t i = 0; i < take.rotations.values.size(); ++i) {
    const bool missing = i / floats % rotations == 1;
    take.rotations.values[i] =
        i % floats == 16 ? (missing ? -1.0F : 1.0F) : static_cast<float>(i % 997);
  }
  return take;
}

/// Column `column` of the first rotation of a frame.
Eigen::Vector3f column(const MarkerSequence& take, std::size_t frame, std::size_t column) {
  const std::size_t at = frame * rotations * samples * floats + 4 * column;
  return Eigen::Map<const Eigen::Vector3f>(take.rotations.values.data() + at);
}

EditResult edited(const MarkerSequence& take, const std::string& toml) {
  return apply_edits(take, parse_edits(toml, "edits.toml"));
}

TEST(EditRotations, CropAndDeletedMarkersKeepThem) {
  const MarkerSequence take = turning_take(40);
  const MarkerSequence out = edited(take,
                                    "[[edit]]\ndo = \"crop\"\nfrom = 11\nto = 30\n"
                                    "[[edit]]\ndo = \"delete\"\nmarkers = [\"M1\"]\n")
                                 .take;
  ASSERT_EQ(out.rotations.values.size(), 20 * rotations * samples * floats);
  EXPECT_EQ(column(out, 0, 0), column(take, 10, 0));
  EXPECT_EQ(column(out, 19, 3), column(take, 29, 3));
  const MarkerSequence back = test::read_encoded(encode_c3d(out)).take;
  EXPECT_TRUE(std::ranges::equal(back.rotations.values.span(), out.rotations.values.span()));
}

TEST(EditRotations, JoinedTakesKeepThemWhenTheyAreAlike) {
  const MarkerSequence first = turning_take(20);
  MarkerSequence second = turning_take(10);
  std::vector<std::string> notes;
  MarkerSequence out = join_takes(first, second, 5, &notes);
  EXPECT_TRUE(notes.empty());
  ASSERT_EQ(out.rotations.values.size(), 35 * rotations * samples * floats);
  EXPECT_EQ(column(out, 25, 3), column(second, 0, 3));
  EXPECT_EQ(column(out, 19, 1), column(first, 19, 1));
  for (std::size_t f = 20; f < 25; ++f) {  // nothing was measured in the pause
    EXPECT_EQ(out.rotations.values[f * rotations * samples * floats + 16], -1.0F);
  }
  second.origin.unit = "m";
  out = join_takes(first, second, 0, &notes);
  EXPECT_EQ(column(out, 20, 3), Eigen::Vector3f(1000.0F * column(second, 0, 3)));
  second.rotations = {};
  out = join_takes(first, second, 0, &notes);
  EXPECT_TRUE(out.rotations.values.empty());
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("rotations are left out"), std::string::npos);
}

TEST(EditRotations, ResamplingLeavesThemOutAndSaysSo) {
  const EditResult out = edited(turning_take(40), "[[edit]]\ndo = \"resample\"\nrate = 50\n");
  EXPECT_TRUE(out.take.rotations.values.empty());
  EXPECT_NE(out.done[0].find("the rotations are left out"), std::string::npos) << out.done[0];
}

TEST(EditRotations, TheyFollowAxesAndUnits) {
  MarkerSequence take = turning_take(5);
  take.origin.y_screen = "+Z";
  const MarkerSequence out = edited(take,
                                    "[[edit]]\ndo = \"axes\"\npreset = \"y-up\"\n"
                                    "[[edit]]\ndo = \"units\"\nunit = \"m\"\n")
                                 .take;
  const auto turned = [](const Eigen::Vector3f& v) {
    return Eigen::Vector3f(v.x(), v.z(), -v.y());
  };
  EXPECT_EQ(column(out, 3, 1), turned(column(take, 3, 1)));
  EXPECT_LT((column(out, 3, 3) - 0.001F * turned(column(take, 3, 3))).norm(), 1e-5F);
}

TEST(EditRotations, StabilisationTurnsThemIntoTheHead) {
  MarkerSequence take = turning_take(30);
  take.origin.unit = "cm";
  const std::array<Eigen::Vector3d, 4> rig = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(80, 0, 10),
                                              Eigen::Vector3d(0, 90, 0), Eigen::Vector3d(0, 0, 70)};
  for (std::size_t f = 0; f < 30; ++f) {
    const auto turn =
        Eigen::AngleAxisd(0.02 * static_cast<double>(f), Eigen::Vector3d(1, 2, -1).normalized())
            .toRotationMatrix();
    const Eigen::Vector3d shift(3.0 * static_cast<double>(f), 5, -1);
    for (std::size_t m = 0; m < 4; ++m) {
      take.position(f, m) = (turn * rig[m] + shift).cast<float>();
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
    }
    // A segment that is fixed to the head, 20 mm in front of it.
    const std::size_t at = f * rotations * samples * floats;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      Eigen::Map<Eigen::Vector3f>(take.rotations.values.data() + at + 4 * c) =
          turn.col(i).cast<float>();
    }
    Eigen::Map<Eigen::Vector3f>(take.rotations.values.data() + at + 12) =
        (0.1 * (turn * Eigen::Vector3d(0, 0, 20) + shift)).cast<float>();
  }
  const std::array<std::size_t, 4> all = {0, 1, 2, 3};
  const MarkerSequence out = stabilise_head(take, all).take;
  for (std::size_t f = 1; f < 30; ++f) {
    for (std::size_t c = 0; c < 4; ++c) {
      EXPECT_LT((column(out, f, c) - column(out, 0, c)).norm(), 1e-4F) << f << " " << c;
    }
  }
  EXPECT_LT((column(out, 0, 3) - Eigen::Vector3f(0.0F, 0.5F, 1.9F)).norm(), 1e-3F);
}

}  // namespace
}  // namespace kinemesh::edit_rotations_test
