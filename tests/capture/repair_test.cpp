// Swaps, spikes and labels on the samples and on real takes.
#include "capture/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "capture/label.h"
#include "capture/session.h"
#include "config/error.h"
#include "tests/support/data.h"
#include "tests/support/faults.h"
#include "tests/support/sanitizers.h"
#include "tests/support/shuffled_take.h"

namespace kinemesh::repair_test {
namespace {

MarkerSequence sample(const std::string& name) {
  return read_session(test::sample_folder() / (name + ".c3d"));
}
MarkerSequence real(const std::string& name) {
  return read_session(test::data_folder() / "c3d_face" / (name + ".c3d"));
}

/// Share of the points, in percent, that got the label they had; points without one count as wrong.
double right_percent(const MarkerSequence& truth, const test::ShuffledTake& from,
                     const LabelResult& got) {
  std::size_t right = 0, points = 0;
  for (std::size_t f = 0; f < truth.frame_count(); ++f) {
    for (const std::size_t m : from.order[f]) {
      ++points;
      const std::size_t column = got.take.find(truth.markers()[m].label);
      if (column == MarkerSequence::npos || !got.take.valid(f, column)) continue;
      right += got.take.position(f, column) == truth.position(f, m) ? 1 : 0;
    }
  }
  return 100.0 * static_cast<double>(right) / static_cast<double>(points);
}

double relabelled(const MarkerSequence& take, const MarkerSequence& other) {
  const test::ShuffledTake loose = test::without_labels(take, 7);
  return right_percent(take, loose, label_points(loose.take, learn_template(other)));
}

TEST(Repair, FindsTheSamplesSwapAndNoOther) {
  const MarkerSequence swapped = sample("ben_surprise");
  const auto swaps = find_label_swaps(swapped);
  ASSERT_EQ(swaps.size(), 1U);
  std::vector<std::string> pair{swapped.markers()[swaps[0].a].label,
                                swapped.markers()[swaps[0].b].label};
  std::ranges::sort(pair);
  EXPECT_EQ(pair, (std::vector<std::string>{"RCHN01", "RMOU06"}));
  EXPECT_EQ(swaps[0].from, 243U);
  for (const char* name : {"anna_happy", "anna_surprise", "ben_happy"}) {
    EXPECT_TRUE(find_label_swaps(sample(name)).empty()) << name;
  }
}

TEST(Repair, FindsNoSwapInRealTakes) {
  KINEMESH_NEED_DATA("c3d_face/Facial-Sing.c3d");
  for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows", "Facial-Sing"}) {
    EXPECT_TRUE(find_label_swaps(real(name)).empty()) << name;
  }
}

TEST(Repair, MendsSwapsOfAnyLengthAndTheyCanBeTakenBack) {
  const MarkerSequence take = sample("anna_happy");
  const std::size_t a = take.find("LCHK04");
  const std::size_t b = take.find("LCHK05");
  ASSERT_NE(a, MarkerSequence::npos);
  ASSERT_NE(b, MarkerSequence::npos);
  EditList swap;
  swap.steps.push_back(make_edit(
      "swap", {{"a", {"LCHK04"}}, {"b", {"LCHK05"}}, {"from", {"101"}}, {"to", {"160"}}}));
  const MarkerSequence broken = apply_edits(take, swap).take;
  const RepairResult mended = repair_take(broken);
  EXPECT_EQ(mended.swaps.size(), 2U);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    EXPECT_EQ(mended.take.valid(f, a), take.valid(f, a)) << f;
    if (!take.valid(f, a)) continue;
    EXPECT_EQ(mended.take.position(f, a), take.position(f, a)) << f;
  }
  // The list gives the same take again; without its steps, the original stays as it was.
  const EditList again = parse_edits(edits_toml(mended.edits), "edits.toml");
  const MarkerSequence replayed = apply_edits(broken, again).take;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    if (!take.valid(f, b)) continue;
    EXPECT_EQ(replayed.position(f, b), mended.take.position(f, b));
  }
  EXPECT_EQ(mended.done.size(), mended.edits.steps.size());
}

TEST(Repair, MendsExchangesOfAFewFramesAndNothingAfterThem) {
  const MarkerSequence take = sample("ben_happy");
  const std::size_t a = take.find("LMOU01");
  const std::size_t b = take.find("LMOU02");
  for (const std::size_t length : {1U, 2U, 3U, 4U, 5U, 7U, 10U}) {
    SCOPED_TRACE(length);
    MarkerSequence broken = take;
    for (std::size_t f = 60; f < 60 + length; ++f) {
      const Eigen::Vector3f p = broken.position(f, a);
      broken.position(f, a) = broken.position(f, b);
      broken.position(f, b) = p;
      std::swap(broken.flags()[broken.sample(f, a)], broken.flags()[broken.sample(f, b)]);
    }
    const MarkerSequence mended = repair_take(broken).take;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      for (const std::size_t m : {a, b}) {
        if (!take.valid(f, m) || !mended.valid(f, m)) continue;
        EXPECT_EQ(mended.position(f, m), take.position(f, m)) << f;
      }
    }
  }
}

TEST(Repair, TheLabelsThatHoldForLongerAreRight) {
  const MarkerSequence take = sample("ben_happy");
  MarkerSequence broken = take;
  test::rotate_labels(broken, {take.find("LMOU01"), take.find("LMOU02")}, 0, 100);
  const RepairResult mended = repair_take(broken);
  ASSERT_EQ(mended.swaps.size(), 1U);
  EXPECT_EQ(mended.swaps[0].from, 0U);
  EXPECT_EQ(mended.swaps[0].until, 100U);
  ASSERT_EQ(mended.done.size(), 1U);
  EXPECT_NE(mended.done[0].find("in frames 1 to 100"), std::string::npos) << mended.done[0];
}

TEST(Repair, AnExchangeInTheFirstFramesIsMendedThere) {
  const MarkerSequence take = sample("ben_happy");
  const std::size_t a = take.find("LMOU01");
  const std::size_t b = take.find("LMOU02");
  MarkerSequence broken = take;
  test::rotate_labels(broken, {a, b}, 0, 5);
  const RepairResult mended = repair_take(broken);
  ASSERT_EQ(mended.swaps.size(), 1U);
  EXPECT_EQ(mended.swaps[0].from, 0U);
  EXPECT_EQ(mended.swaps[0].until, 5U);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    if (take.valid(f, a)) {
      EXPECT_EQ(mended.take.position(f, a), take.position(f, a)) << f;
    }
  }
  const EditList again = parse_edits(edits_toml(mended.edits), "edits.toml");
  EXPECT_EQ(apply_edits(broken, again).take.position(3, a), take.position(3, a));
}

TEST(Repair, TakesOutSpikesAndNothingElse) {
  MarkerSequence take = sample("anna_surprise");
  EXPECT_TRUE(find_spikes(take).empty());
  struct Put {
    std::size_t frame, length, marker;
    float size_mm;
  };
  const std::vector<Put> spikes{{100, 1, 3, 4.0F}, {200, 2, 40, 8.0F}, {333, 3, 99, 20.0F}};
  for (const Put& s : spikes) {
    for (std::size_t f = s.frame; f < s.frame + s.length; ++f) {
      ASSERT_TRUE(take.valid(f, s.marker));
      take.position(f, s.marker).y() += s.size_mm;
    }
  }
  const auto found = find_spikes(take);
  ASSERT_EQ(found.size(), spikes.size());
  for (std::size_t i = 0; i < spikes.size(); ++i) {
    EXPECT_EQ(found[i].marker, spikes[i].marker);
    EXPECT_EQ(found[i].frames, (FrameRange{spikes[i].frame, spikes[i].frame + spikes[i].length}));
    EXPECT_NEAR(found[i].deviation_mm, spikes[i].size_mm, 2.0);
  }
  const RepairResult mended = repair_take(take);
  EXPECT_FALSE(mended.take.valid(100, 3));
  EXPECT_TRUE(mended.take.valid(101, 3));
}

TEST(Repair, SpikesAtGapsAndAtTheTakesEndsAreFound) {
  MarkerSequence take = sample("anna_surprise");
  const std::size_t last = take.frame_count();
  for (std::size_t f = 150; f < 190; ++f) take.flags()[take.sample(f, 30)] = 0;
  const std::vector<Spike> put{{10, {0, 2}, 12.0},
                               {20, {last - 1, last}, 9.0},
                               {30, {148, 150}, 15.0},  // before the gap
                               {30, {190, 191}, 9.0}};  // behind it
  for (const Spike& s : put) {
    for (std::size_t f = s.frames.begin; f < s.frames.end; ++f) {
      ASSERT_TRUE(take.valid(f, s.marker)) << s.marker << " " << f;
      take.position(f, s.marker).z() += static_cast<float>(s.deviation_mm);
    }
  }
  const auto found = find_spikes(take);
  ASSERT_EQ(found.size(), put.size());
  for (const Spike& s : put) {
    const auto same = std::ranges::find_if(found, [&](const Spike& other) {
      return other.marker == s.marker && other.frames == s.frames;
    });
    ASSERT_NE(same, found.end()) << s.marker << " " << s.frames.begin;
    EXPECT_NEAR(same->deviation_mm, s.deviation_mm, 3.0);
  }
}

TEST(Repair, AStepIsNoSpikeButAJump) {
  MarkerSequence take = sample("anna_surprise");
  const std::size_t marker = 40;
  for (std::size_t f = 200; f < take.frame_count(); ++f) {
    take.position(f, marker) += Eigen::Vector3f(25.0F, -40.0F, 30.0F);
  }
  const RepairResult found = repair_take(take);
  EXPECT_TRUE(found.spikes.empty());
  EXPECT_TRUE(found.swaps.empty());
  ASSERT_EQ(found.jumps.size(), 1U);
  EXPECT_EQ(found.jumps[0].marker, marker);
  EXPECT_EQ(found.jumps[0].frame, 200U);
  EXPECT_NEAR(found.jumps[0].size_mm, std::sqrt(25.0 * 25 + 40.0 * 40 + 30.0 * 30), 2.0);
  EXPECT_TRUE(repair_take(sample("anna_surprise")).jumps.empty());
}

TEST(Repair, RealMotionIsNoSpike) {
  KINEMESH_NEED_DATA("c3d_face/AnimFace-Jaw.c3d");
  for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows"}) {
    EXPECT_TRUE(find_spikes(real(name)).empty()) << name;
  }
}

TEST(Labelling, SamplesWithoutAnyLabel) {
  const MarkerSequence happy = sample("anna_happy");
  const MarkerSequence surprise = sample("anna_surprise");
  EXPECT_GE(relabelled(surprise, happy), 99.5);
  EXPECT_GE(relabelled(happy, surprise), 99.5);
}

TEST(Labelling, SamplesWithNoiseAndManyMoreGaps) {
  MarkerSequence take = sample("anna_surprise");
  std::mt19937 random(4);
  std::normal_distribution<float> noise(0.0F, 0.3F);
  for (float& v : take.positions()) v += noise(random);
  constexpr std::size_t length = 36;
  for (std::size_t i = 0; i < take.sample_count() / length / 5; ++i) {  // of a fifth
    const std::size_t m = random() % take.marker_count();
    const std::size_t f = random() % (take.frame_count() - length);
    for (std::size_t k = f; k < f + length; ++k) take.flags()[take.sample(k, m)] = 0;
  }
  EXPECT_GE(relabelled(take, sample("anna_happy")), 99.5);
}

TEST(Labelling, SamplesOfTheOtherSubject) {
  KINEMESH_LEAVE_TO_RELEASE("SamplesWithoutAnyLabel");
  const MarkerSequence happy = sample("ben_happy");
  const MarkerSequence surprise = repair_take(sample("ben_surprise"), {.spikes = false}).take;
  EXPECT_GE(relabelled(surprise, happy), 99.5);
  EXPECT_GE(relabelled(happy, surprise), 99.5);
}

TEST(Labelling, OneRealTakeFromTheOther) {
  KINEMESH_NEED_DATA("c3d_face/AnimFace-Jaw.c3d");
  const MarkerSequence jaw = real("AnimFace-Jaw");
  const MarkerSequence brows = real("AnimFace-Eyebrows");
  EXPECT_GE(relabelled(jaw, brows), 98.0);
  EXPECT_GE(relabelled(brows, jaw), 98.0);
}

TEST(Labelling, ATurnedHeadIsFound) {
  const MarkerSequence happy = sample("anna_happy");
  MarkerSequence turned = sample("anna_surprise");
  const Eigen::Matrix3f rotation =
      Eigen::AngleAxisf(2.4F, Eigen::Vector3f(1, 2, -0.5F).normalized()).toRotationMatrix();
  for (std::size_t f = 0; f < turned.frame_count(); ++f) {
    for (std::size_t m = 0; m < turned.marker_count(); ++m) {
      const Eigen::Vector3f p = turned.position(f, m);
      turned.position(f, m) = rotation * p + Eigen::Vector3f(500, -300, 90);
    }
  }
  EXPECT_GE(relabelled(turned, happy), 99.5);
}

TEST(Labelling, BrokenTrajectoriesAreMended) {
  const MarkerSequence take = sample("anna_happy");
  std::vector<Marker> markers = take.markers();
  markers.push_back({.label = "*1", .kind = MarkerKind::unlabelled});
  const std::size_t loose = markers.size() - 1;
  auto broken = MarkerSequence::invalid(take.frame_count(), markers, take.rate_hz);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const bool lost = m == 20 && f >= 150 && f < 300;
      broken.position(f, lost ? loose : m) = take.position(f, m);
      broken.flags()[broken.sample(f, lost ? loose : m)] = take.flags()[take.sample(f, m)];
    }
  }
  const LabelResult got = label_points(broken, learn_template(broken));
  EXPECT_EQ(got.take.marker_count(), take.marker_count());
  std::size_t right = 0, points = 0;
  for (std::size_t f = 150; f < 300; ++f) {
    if (!take.valid(f, 20)) continue;
    ++points;
    right += got.take.valid(f, 20) && got.take.position(f, 20) == take.position(f, 20) ? 1 : 0;
  }
  EXPECT_EQ(right, points);
  EXPECT_GT(points, 100U);
}

TEST(Labelling, BadInput) {
  const MarkerSequence happy = sample("anna_happy");
  const SubjectTemplate subject = learn_template(happy);
  EXPECT_THROW(learn_template(MarkerSequence::invalid(5, {{.label = "A"}}, 100.0)), NoResultError);
  // Points that are no such face.
  MarkerSequence other = MarkerSequence::invalid(3, {}, 100.0);
  other.unlabelled.offsets = {0, 3, 6, 9};
  for (int i = 0; i < 9; ++i) {
    other.unlabelled.positions.emplace_back(static_cast<float>(i * i), 3.0F, 5.0F);
  }
  EXPECT_THROW(label_points(other, subject), NoResultError);
  EXPECT_EQ(label_points(happy, subject).points, 0U);  // nothing to do
}

}  // namespace
}  // namespace kinemesh::repair_test
