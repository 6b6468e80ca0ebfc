#include "capture/clean_picture.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "capture/clean.h"
#include "capture/session.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"

namespace kinemesh::clean_picture_test {
namespace {

MarkerSequence sample(const char* name) { return read_session(test::sample_folder() / name); }

/// The texts that the picture shows.
std::string shown(const Canvas& canvas) { return canvas.svg(); }

TEST(CleanPicture, ShowsGapsChangesUncertaintyAndTheHead) {
  const MarkerSequence before = sample("ben_surprise.c3d");
  const CleanResult clean = clean_take(before, {.stabilise = true});
  const std::string text =
      shown(draw_cleaning(before, clean.take, clean.edits, "ben_surprise.c3d"));
  EXPECT_NE(text.find("What was done to ben_surprise.c3d"), std::string::npos);
  EXPECT_NE(text.find("RMOU06: moved by 1"), std::string::npos);  // the exchange of labels
  EXPECT_NE(text.find("RCHN01: moved by 1"), std::string::npos);
  EXPECT_NE(text.find(">before<"), std::string::npos);
  EXPECT_NE(text.find("estimated, uncertain by up to 0."), std::string::npos);
  EXPECT_NE(text.find("Head before stabilising, motion per frame (rigid markers, RMS)"),
            std::string::npos);
  EXPECT_NE(text.find("Head after stabilising, error per frame (rigid markers, RMS)"),
            std::string::npos);
}

TEST(CleanPicture, ShowsNoStretchTwice) {
  // A marker that was elsewhere for a while is taken out and filled: one chart says both.
  MarkerSequence before = sample("anna_happy.c3d");
  const std::size_t m = before.find("LCHK05");
  EditList edits;
  MarkerSequence after = before;
  for (std::size_t f = 200; f < 240; ++f) before.position(f, m).x() += 40.0F;
  after.add_uncertainty();
  for (std::size_t f = 200; f < 240; ++f) {
    after.flags()[after.sample(f, m)] = SampleFlag::valid | SampleFlag::filled;
    after.uncertainty()[after.sample(f, m)] = 1.5F;
  }
  const std::string text = shown(draw_cleaning(before, after, edits, "a"));
  EXPECT_NE(text.find("LCHK05: moved by 40.0"), std::string::npos);
  EXPECT_EQ(text.find("LCHK05: estimated"), std::string::npos);
}

TEST(CleanPicture, WithoutStabilisingThereIsNoHead) {
  const MarkerSequence before = sample("anna_happy.c3d");
  const CleanResult clean = clean_take(before);
  const std::string text = shown(draw_cleaning(before, clean.take, clean.edits, "a"));
  EXPECT_EQ(text.find("Head "), std::string::npos);
  EXPECT_EQ(text.find("moved by"), std::string::npos);  // nothing had to be repaired
  EXPECT_NE(text.find("uncertain by up to"), std::string::npos);
}

TEST(CleanPicture, ExchangedLabelsAreRepairsAndACleanTakeIsSaidToBe) {
  MarkerSequence take = test::make_take(100, 6);
  std::ranges::fill(take.flags(), SampleFlag::valid);
  EXPECT_NE(
      shown(draw_cleaning(take, take, {}, "a")).find("Nothing was missing, nothing was repaired"),
      std::string::npos);
  const auto edits =
      parse_edits("[[edit]]\ndo = \"swap\"\na = \"" + take.markers()[0].label + "\"\nb = \"" +
                      take.markers()[1].label + "\"\nfrom = 20\nto = 40\n",
                  "edits.toml");
  const Canvas canvas = draw_cleaning(take, apply_edits(take, edits).take, edits, "a");
  EXPECT_EQ(shown(canvas).find("Nothing was missing"), std::string::npos);
}

TEST(CleanPicture, TakesThatCannotBeLaidOverEachOtherAreDrawn) {
  const MarkerSequence before = sample("anna_happy.c3d");
  for (const char* toml :
       {"[[edit]]\ndo = \"crop\"\nfrom = 101\nto = 200\n",
        "[[edit]]\ndo = \"axes\"\npreset = \"y-up\"\n", "[[edit]]\ndo = \"resample\"\nrate = 50\n",
        "[[edit]]\ndo = \"fill\"\n"
        "[[edit]]\ndo = \"crop\"\nfrom = 7\nto = 7\n"}) {
    const EditList edits = parse_edits(toml, "edits.toml");
    const EditResult after = apply_edits(before, edits);
    const Canvas canvas = draw_cleaning(before, after.take, edits, "a");
    EXPECT_GT(canvas.height(), 100.0) << toml;
    EXPECT_EQ(shown(canvas).find("moved by"), std::string::npos) << toml;
    EXPECT_EQ(shown(canvas).find(">before<"), std::string::npos) << toml;
  }
}

}  // namespace
}  // namespace kinemesh::clean_picture_test
