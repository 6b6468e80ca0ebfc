#include "capture/quality.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "capture/clean.h"
#include "capture/session.h"
#include "capture/stabilise.h"
#include "config/error.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"
#include "tests/support/faults.h"
#include "tests/support/samples.h"
#include "tests/support/sanitizers.h"

namespace kinemesh::quality_test {
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

MarkerSequence with_swaps(MarkerSequence take, std::size_t count) {
  // Each pair of neighbours exchanges its labels for a while.
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t from = 40 + 300 * i / std::max<std::size_t>(count, 1);
    test::rotate_labels(take, {20 + 2 * i, 21 + 2 * i}, from, from + 60);
  }
  return take;
}

MarkerSequence with_residuals(MarkerSequence take, double mm) {
  for (std::size_t i = 0; i < take.sample_count(); ++i) {
    take.residuals()[i] = static_cast<float>(mm);
  }
  return take;
}

/// The head turns by this angle and back, beside what it does anyway.
MarkerSequence with_turned_head(MarkerSequence take, double degrees, double turns = 1.0) {
  const double frames = static_cast<double>(take.frame_count());
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const double angle =
        degrees * std::numbers::pi / 180.0 *
        std::pow(std::sin(turns * std::numbers::pi * static_cast<double>(f) / frames), 2);
    const Eigen::Matrix3f turn =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix().cast<float>();
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const Eigen::Vector3f p = take.position(f, m);
      take.position(f, m) = turn * p;
    }
  }
  return take;
}

MarkerSequence with_repeated_frames(MarkerSequence take, std::size_t every) {
  for (std::size_t f = every; f < take.frame_count(); f += every) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const Eigen::Vector3f p = take.position(f - 1, m);
      take.position(f, m) = p;
      take.flags()[take.sample(f, m)] = take.flags()[take.sample(f - 1, m)];
    }
  }
  return take;
}

Verdict verdict_of(const MarkerSequence& take) { return assess_take(take).verdict; }

/// The verdicts of the take made worse step by step; none may be better than the one before.
template <class Degrade>
std::string steps(const Degrade& degrade, std::initializer_list<double> amounts) {
  std::string verdicts;
  int before = 0;
  for (const double amount : amounts) {
    const Verdict v = verdict_of(degrade(amount));
    EXPECT_GE(static_cast<int>(v), before) << amount;
    before = static_cast<int>(v);
    verdicts += "fcr"[before];
  }
  return verdicts;
}

TEST(Quality, TheVerdictFollowsGapsAndDroppedFrames) {
  const MarkerSequence take = sample("anna_happy");
  EXPECT_EQ(verdict_of(take), Verdict::fit_after_cleaning);
  EXPECT_EQ(steps([&](double s) { return with_gaps(take, s); }, {0.0, 0.05, 0.10, 0.4, 0.8}),
            "cccrr");
  EXPECT_EQ(steps([&](double n) { return with_dropped_frames(take, static_cast<std::size_t>(n)); },
                  {400, 100, 10, 4}),
            "ccrr");
}

TEST(Quality, TheVerdictFollowsNoiseLostMarkersAndRepeatedFrames) {
  KINEMESH_LEAVE_TO_RELEASE("TheVerdictFollowsGapsAndDroppedFrames");
  const MarkerSequence take = sample("anna_happy");
  EXPECT_EQ(steps([&](double s) { return with_noise(take, s); }, {0.0, 0.2, 0.5, 1.5, 3.0}),
            "cccrr");
  EXPECT_EQ(steps([&](double n) { return without_markers(take, static_cast<std::size_t>(n)); },
                  {0, 2, 12, 40}),
            "ccrr");
  EXPECT_EQ(steps([&](double n) { return with_repeated_frames(take, static_cast<std::size_t>(n)); },
                  {400, 100, 10, 4}),
            "ccrr");
}

/// The head held still, no noise, no gap: as good as a take can be.
MarkerSequence faultless() { return stabilise_head(test::make_sample("anna_happy").truth).take; }

/// The verdicts of the take with more and more of a fault: f(it), c(lean), r(epeat).
template <class Degrade>
std::string verdicts(const Degrade& degrade, std::initializer_list<double> amounts,
                     const std::string& reason) {
  std::string got;
  for (const double amount : amounts) {
    const QualityResult result = assess_take(degrade(amount));
    got += "fcr"[static_cast<int>(result.verdict)];
    const std::string line = quality_line(result);
    if (result.verdict == Verdict::fit) continue;
    EXPECT_NE(line.find(reason), std::string::npos) << line;
  }
  return got;
}

TEST(Quality, TheVerdictFollowsFaultsOfLabelsAndPaths) {
  KINEMESH_LEAVE_TO_RELEASE("TheVerdictFollowsFaultsOfTheRecording");
  const MarkerSequence take = faultless();
  ASSERT_EQ(verdict_of(take), Verdict::fit) << quality_line(assess_take(take));
  const auto swapped = [&](double n) { return with_swaps(take, static_cast<std::size_t>(n)); };
  EXPECT_EQ(verdicts(swapped, {0, 1, 12}, "label swap"), "fcr");
  // Labels that go round are one exchange, however many they are.
  MarkerSequence round = take;
  test::rotate_labels(
      round, {take.find("LCHK04"), take.find("LCHK05"), take.find("LCHK06"), take.find("LCHK07")},
      200, 260);
  const std::string line = quality_line(assess_take(round));
  EXPECT_NE(line.find("2 label swaps"), std::string::npos) << line;
  EXPECT_EQ(verdict_of(round), Verdict::fit_after_cleaning);
  const auto spiky = [&](double share) { return test::with_spikes(take, share, 3).take; };
  EXPECT_EQ(verdicts(spiky, {0.001, 0.005, 0.03}, "spike"), "ccr");
  const auto noisy = [&](double sd) { return with_noise(take, sd); };
  EXPECT_EQ(verdicts(noisy, {0.1, 0.6, 1.5}, "noise"), "fcr");
  const auto gappy = [&](double share) { return with_gaps(take, share); };
  EXPECT_EQ(verdicts(gappy, {0.05, 0.5}, "samples"), "cr");
}

TEST(Quality, TheVerdictFollowsFaultsOfTheRecording) {
  const MarkerSequence take = faultless();
  const auto coarse = [&](double mm) { return with_residuals(take, mm); };
  EXPECT_EQ(verdicts(coarse, {1.0, 2.0, 5.0}, "residual"), "fcr");
  const auto turned = [&](double angle) { return with_turned_head(take, angle); };
  EXPECT_EQ(verdicts(turned, {5, 30, 100}, "the head turns"), "fcr");
  const auto shaken = [&](double turns) { return with_turned_head(take, 20.0, turns); };
  EXPECT_EQ(verdicts(shaken, {1, 20}, "the head"), "cr");
  const auto dropped = [&](double n) {
    return with_dropped_frames(take, static_cast<std::size_t>(n));
  };
  EXPECT_EQ(verdicts(dropped, {1000, 100, 10}, "dropped"), "fcr");
  const auto repeated = [&](double n) {
    return with_repeated_frames(take, static_cast<std::size_t>(n));
  };
  EXPECT_EQ(verdicts(repeated, {100, 10}, "repeat"), "cr");
}

TEST(Quality, TwinsAreUnitedBeforeAnythingIsLookedAt) {
  const MarkerSequence take = sample("anna_happy");
  std::vector<Marker> markers = take.markers();
  markers.push_back(markers[30]);  // its second half comes under a second column
  auto broken = MarkerSequence::invalid(take.frame_count(), markers, take.rate_hz);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const std::size_t to = m == 30 && f > 200 ? markers.size() - 1 : m;
      broken.position(f, to) = take.position(f, m);
      broken.flags()[broken.sample(f, to)] = take.flags()[take.sample(f, m)];
    }
  }
  const QualityResult result = assess_take(broken);
  EXPECT_EQ(result.twins, 1U);
  EXPECT_EQ(result.markers, take.marker_count());
  EXPECT_NEAR(result.visible_percent, assess_take(take).visible_percent, 1e-9);
  EXPECT_EQ(result.lost_markers, 0U);
  EXPECT_NE(quality_line(result).find("used twice, joined the two trajectories of " +
                                      take.markers()[30].label),
            std::string::npos)
      << quality_line(result);
}

TEST(Quality, OutOfViewIsNotDropped) {
  MarkerSequence take = sample("anna_happy");
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    if (f >= 20 && (f < 200 || f >= 230) && f != 300) continue;  // begin, middle, one frame
    for (std::size_t m = 0; m < take.marker_count(); ++m) take.flags()[take.sample(f, m)] = 0;
  }
  const QualityResult result = assess_take(take);
  EXPECT_EQ(result.dropped_frames, 1U);
  EXPECT_NEAR(result.longest_blind_s, 30.0 / 120.0, 1e-9);
}

TEST(Quality, AbsurdSpikesAreSaidToBe) {
  MarkerSequence take = sample("anna_happy");
  take.position(100, 40).x() += 65000.0F;
  const std::string line = quality_line(assess_take(take));
  EXPECT_NE(line.find("1 spike of up to 65.0 m: no marker was there"), std::string::npos) << line;
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
  MarkerSequence loose = MarkerSequence::invalid(2, {}, 100.0);
  loose.unlabelled.offsets = {0, 1, 2};
  loose.unlabelled.positions.assign(2, Eigen::Vector3f::Zero());
  EXPECT_EQ(verdict_of(loose), Verdict::unlabelled);
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
  // A median of one frame: a shorter window would not help.
  try {
    clean_take(one, {.filter = {.method = FilterMethod::median}});
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("Leave --filter out"), std::string::npos) << e.what();
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
    take.position(f, 1) = take.position(f, 0);
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
}  // namespace kinemesh::quality_test
