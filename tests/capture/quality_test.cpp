#include "capture/quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/clean.h"
#include "capture/session.h"
#include "capture/stabilise.h"
#include "config/error.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"

namespace kinemesh {
namespace {

MarkerSequence sample(const std::string& name) {
  return read_session(test::sample_folder() / (name + ".c3d"));
}

/// Removes this share of all samples in runs of a tenth of a second.
MarkerSequence with_gaps(MarkerSequence take, double share) {
  std::mt19937 random(5);
  const std::size_t length = 12;
  const auto runs = static_cast<std::size_t>(share * static_cast<double>(take.sample_count()) /
                                             static_cast<double>(length));
  for (std::size_t i = 0; i < runs; ++i) {
    const std::size_t m = random() % take.marker_count();
    const std::size_t f = random() % (take.frame_count() - length);
    for (std::size_t k = 0; k < length; ++k) take.flags()[take.sample(f + k, m)] = 0;
  }
  return take;
}

MarkerSequence with_noise(MarkerSequence take, double sd_mm) {
  std::mt19937 random(6);
  std::normal_distribution<float> noise(0.0F, static_cast<float>(sd_mm));
  for (float& v : take.positions()) v += noise(random);
  return take;
}

MarkerSequence with_dropped_frames(MarkerSequence take, std::size_t every) {
  for (std::size_t f = every; f + 1 < take.frame_count(); f += every) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) take.flags()[take.sample(f, m)] = 0;
  }
  return take;
}

MarkerSequence without_markers(MarkerSequence take, std::size_t count) {
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < count; ++m) take.flags()[take.sample(f, 20 + m)] = 0;
  }
  return take;
}

Verdict verdict_of(const MarkerSequence& take) { return assess_take(take).verdict; }

TEST(Quality, TheVerdictFollowsTheDegradation) {
  const MarkerSequence take = sample("anna_happy");
  EXPECT_EQ(verdict_of(take), Verdict::fit_after_cleaning);
  const auto steps = [&](auto&& degrade, std::initializer_list<double> amounts) {
    std::string verdicts;
    int before = 0;
    for (const double amount : amounts) {
      const Verdict v = verdict_of(degrade(amount));
      EXPECT_GE(static_cast<int>(v), before) << amount;
      before = static_cast<int>(v);
      verdicts += "fcr"[before];
    }
    return verdicts;
  };
  EXPECT_EQ(steps([&](double s) { return with_gaps(take, s); }, {0.0, 0.05, 0.10, 0.4, 0.8}),
            "cccrr");
  EXPECT_EQ(steps([&](double s) { return with_noise(take, s); }, {0.0, 0.2, 0.5, 1.5, 3.0}),
            "cccrr");
  EXPECT_EQ(steps([&](double n) { return with_dropped_frames(take, static_cast<std::size_t>(n)); },
                  {400, 100, 10, 4}),
            "ccrr");
  EXPECT_EQ(steps([&](double n) { return without_markers(take, static_cast<std::size_t>(n)); },
                  {0, 2, 12, 40}),
            "ccrr");
}

TEST(Quality, ReasonsNameWhatIsWrong) {
  const QualityResult lost = assess_take(without_markers(sample("anna_happy"), 40));
  EXPECT_NE(quality_line(lost).find("repeat the take: "), std::string::npos);
  EXPECT_NE(quality_line(lost).find("markers of 173"), std::string::npos) << quality_line(lost);
  const QualityResult swapped = assess_take(sample("ben_surprise"));
  EXPECT_EQ(swapped.swaps.size(), 1U);
  EXPECT_NE(quality_line(swapped).find("1 label swap"), std::string::npos);
  EXPECT_NEAR(swapped.noise_mm, 0.15, 0.03);
  EXPECT_TRUE(swapped.head.known);
  EXPECT_GT(swapped.head.turn_degrees, 2.0);
  const std::string json = quality_json(swapped, "x.c3d");
  EXPECT_NE(json.find("\"RCHN01\""), std::string::npos);
  EXPECT_GT(draw_quality(swapped, "ben").height(), 300.0);
}

TEST(Quality, RealTakes) {
  KINEMESH_NEED_DATA("c3d_face/Facial-Sing.c3d");
  const auto verdict = [](const char* name) {
    return assess_take(read_session(test::data_folder() / "c3d_face" / name)).verdict;
  };
  EXPECT_EQ(verdict("AnimFace-Jaw.c3d"), Verdict::fit);
  EXPECT_EQ(verdict("AnimFace-Eyebrows.c3d"), Verdict::fit);
  EXPECT_EQ(verdict("Facial-Sing.c3d"), Verdict::fit_after_cleaning);
}

TEST(Quality, BadInputIsGradedNotRefused) {
  EXPECT_EQ(verdict_of(MarkerSequence::invalid(0, {{.label = "A"}}, 100.0)), Verdict::repeat);
  EXPECT_EQ(verdict_of(MarkerSequence::invalid(50, {}, 100.0)), Verdict::repeat);
  EXPECT_EQ(verdict_of(MarkerSequence::invalid(50, {{.label = "A"}}, 100.0)), Verdict::repeat);
  EXPECT_EQ(verdict_of(test::make_take(1, 5)), Verdict::repeat);
  MarkerSequence twins = test::make_take(60, 5);
  twins.rate_hz = 0.0;
  twins.markers()[1].label = twins.markers()[0].label;
  EXPECT_EQ(assess_take(twins).twins, 1U);
}

TEST(Clean, TheWholeChainAndItsListGiveTheSame) {
  const MarkerSequence take = sample("ben_surprise");
  const CleanResult result = clean_take(take, {.filter = {.cutoff_hz = 12.0}, .stabilise = true});
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) EXPECT_TRUE(result.take.valid(f, m));
  }
  EXPECT_NE(result.done.front().find("RMOU06"), std::string::npos);
  const EditList list = parse_edits(edits_toml(result.edits), "edits.toml");
  const MarkerSequence again = apply_edits(take, list).take;
  EXPECT_TRUE(std::ranges::equal(again.positions(), result.take.positions()));
  EXPECT_TRUE(std::ranges::equal(again.flags(), result.take.flags()));
}

TEST(Clean, StillSkinStandsInForALostHeadRig) {
  MarkerSequence take = sample("anna_happy");
  for (const char* rig : {"LFHD", "RFHD", "LBHD", "RBHD", "HeadTop", "rootNape"}) {
    const std::size_t m = take.find(rig);
    ASSERT_NE(m, MarkerSequence::npos) << rig;
    for (std::size_t f = 0; f < take.frame_count(); ++f) take.flags()[take.sample(f, m)] = 0;
  }
  const StabiliseResult steady = stabilise_head(take);
  EXPECT_TRUE(steady.chosen_from_motion);
  ASSERT_FALSE(steady.warnings.empty());
  EXPECT_NE(steady.warnings.back().find("head rig"), std::string::npos) << steady.warnings.back();
  EXPECT_LT(steady.rms_error_mm, 0.5);
}

TEST(Clean, BadInput) {
  EXPECT_THROW(clean_take(MarkerSequence::invalid(0, {}, 100.0)), NoResultError);
  MarkerSequence loose = MarkerSequence::invalid(2, {}, 100.0);
  loose.unlabelled.offsets = {0, 1, 2};
  loose.unlabelled.positions.assign(2, Eigen::Vector3f::Zero());
  try {
    clean_take(loose);
    FAIL();
  } catch (const NoResultError& e) {
    EXPECT_NE(std::string(e.what()).find("--template"), std::string::npos) << e.what();
  }
  // One frame: nothing to fill or smooth, nothing breaks.
  const MarkerSequence one = test::make_take(1, 6);
  EXPECT_EQ(clean_take(one, {.filter = {.cutoff_hz = 10.0}}).take.frame_count(), 1U);
  // No rigid markers left.
  MarkerSequence free = sample("anna_happy");
  for (std::size_t f = 0; f < free.frame_count(); ++f) {
    for (std::size_t m = 0; m < free.marker_count(); ++m) {
      if (m > 1) free.flags()[free.sample(f, m)] = 0;
    }
  }
  try {
    clean_take(free, {.stabilise = true});
    FAIL();
  } catch (const NoResultError& e) {
    EXPECT_NE(std::string(e.what()).find("--rigid"), std::string::npos) << e.what();
  }
  // A region that was never seen stays open, and is said.
  const MarkerSequence blind = without_markers(sample("anna_happy"), 30);
  const CleanResult cleaned = clean_take(blind);
  EXPECT_NE(cleaned.done.back().find("30 markers without any measurement"), std::string::npos)
      << cleaned.done.back();
}

TEST(Clean, AMarkerThatExistsTwice) {
  MarkerSequence take = test::make_take(40, 4);
  for (std::size_t f = 0; f < 40; ++f) {
    take.flags()[take.sample(f, 0)] = f < 20 ? SampleFlag::valid : 0;
    take.flags()[take.sample(f, 1)] = f < 20 ? 0 : SampleFlag::valid;
  }
  take.markers()[1].label = take.markers()[0].label;  // one trajectory, broken in two
  take.markers()[3].label = take.markers()[2].label;  // two that are apart
  const CleanResult result = clean_take(take, {.repair = false, .fill = false});
  ASSERT_EQ(result.take.marker_count(), 3U);
  EXPECT_TRUE(result.take.valid(5, 0) && result.take.valid(35, 0));
  EXPECT_EQ(result.take.markers()[2].label, take.markers()[2].label + "_2");
  EXPECT_NE(result.done[0].find("joined"), std::string::npos);
  EXPECT_NE(result.done[0].find("renamed"), std::string::npos);
}

}  // namespace
}  // namespace kinemesh
