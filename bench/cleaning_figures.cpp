// What docs/capture.md states about cleaning, measured on the samples and on generated takes with
// known truth: `cleaning_figures speed|stabilise|labels|swaps|spikes|strays`, one JSON object a
// line.
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <random>
#include <string>

#include "capture/clean.h"
#include "capture/label.h"
#include "capture/repair.h"
#include "capture/rigid_markers.h"
#include "capture/session.h"
#include "capture/stabilise.h"
#include "tests/support/data.h"
#include "tests/support/faults.h"
#include "tests/support/samples.h"
#include "tests/support/shuffled_take.h"

namespace kinemesh::test {
namespace {

using Clock = std::chrono::steady_clock;

/// A minute of talking, smiling and surprise.
Motion long_motion(double seconds) {
  Motion all;
  all.name = "session";
  constexpr double each_s = 3.5;
  const MotionKind kinds[] = {MotionKind::talk, MotionKind::happy, MotionKind::surprise,
                              MotionKind::puff, MotionKind::brows};
  std::size_t i = 0;
  for (double begin = 0.0; begin + each_s <= seconds; begin += each_s, ++i) {
    for (ExpressionPulse pulse : vary(make_motion(kinds[i % 5]), i + 1).pulses) {
      pulse.onset_s += begin;
      pulse.peak_s += begin;
      pulse.release_s += begin;
      pulse.end_s += begin;
      all.pulses.push_back(pulse);
    }
  }
  return all;
}

SyntheticTake long_take(double seconds) {
  TakeOptions options;
  options.duration_s = seconds;
  // As many gaps a second as the samples have.
  options.short_gaps = static_cast<std::size_t>(seconds * 17);
  options.long_gaps = static_cast<std::size_t>(seconds * 2);
  options.head_degrees = 6;
  options.head_mm = 25;
  options.head_rig = true;
  options.seed = 11;
  return make_take(sample_face("anna"), sample_layout("anna"), long_motion(seconds), options);
}

void speed() {
  const SyntheticTake take = long_take(60.0);
  std::size_t gaps = 0;
  for (const MarkerGaps& g : find_gaps(take.measured)) gaps += g.gaps.size();
  CleanResult best;
  double least = 1e9;
  double least_processor = 1e9;  // of all threads together: what others do does not count
  double stage_sum = 0.0;
  constexpr int repetitions = 5;
  for (int i = 0; i < repetitions; ++i) {
    const auto start = Clock::now();
    const std::clock_t processor = std::clock();
    CleanResult result = clean_take(take.measured);
    least_processor =
        std::min(least_processor, static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (seconds >= least) continue;
    least = seconds;
    best = std::move(result);
  }
  std::string stages;
  for (const StageTime& t : best.times) {
    stages += ", \"" + t.stage + "_s\": " + std::to_string(t.seconds);
    stage_sum += t.seconds;
  }
  double squares = 0.0, samples = 0.0;
  for (std::size_t f = 0; f < best.take.frame_count(); ++f) {
    for (std::size_t m = 0; m < best.take.marker_count(); ++m) {
      if (!best.take.filled(f, m)) continue;
      squares += (best.take.position(f, m) - take.truth.position(f, m)).squaredNorm();
      samples += 1.0;
    }
  }
  std::printf(
      "{\"take\": \"60 s\", \"markers\": %zu, \"frames\": %zu, \"gaps\": %zu, \"seconds\": %.4f%s, "
      "\"fill_rms_mm\": %.4f, \"repairs\": %zu, \"other_s\": %.4f, \"processor\": %.4f}\n",
      take.measured.marker_count(), take.measured.frame_count(), gaps, least, stages.c_str(),
      std::sqrt(squares / samples), best.edits.steps.size() - 1, least - stage_sum,
      least_processor);
}

/// What is left of the head's motion when the poses are taken out: RMS over the frames, up to a
/// constant change of coordinates.
struct Left {
  double degrees = 0.0, mm = 0.0;
};

Left left_of(const std::vector<Eigen::Isometry3d>& truth,
             const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<Eigen::Isometry3d> relative;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
  for (std::size_t f = 0; f < truth.size(); ++f) {
    relative.push_back(truth[f].inverse() * poses[f]);
    turn += relative.back().rotation();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turn, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d mean = svd.matrixU() * svd.matrixV().transpose();
  // The head's middle, (0, 0, 0) of the true coordinates, as the poses see it.
  for (const auto& r : relative) {
    centre += (r.inverse() * Eigen::Vector3d::Zero()) / static_cast<double>(truth.size());
  }
  Left left;
  for (const auto& r : relative) {
    const double angle =
        Eigen::AngleAxisd(r.rotation() * mean.transpose()).angle() * 180.0 / std::numbers::pi;
    left.degrees += angle * angle / static_cast<double>(truth.size());
    left.mm += (r * centre).squaredNorm() / static_cast<double>(truth.size());
  }
  return {std::sqrt(left.degrees), std::sqrt(left.mm)};
}

std::vector<Eigen::Isometry3d> as_isometries(const std::vector<HeadPose>& poses) {
  std::vector<Eigen::Isometry3d> out;
  for (const HeadPose& p : poses) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = p.rotation;
    pose.translation() = p.translation;
    out.push_back(pose);
  }
  return out;
}

/// Plain least squares of the measured rig to its true shape, frame by frame; where fewer than
/// three are seen, the pose of the frame before.
std::vector<Eigen::Isometry3d> least_squares(const SyntheticTake& take) {
  std::vector<Eigen::Isometry3d> out;
  for (std::size_t f = 0; f < take.measured.frame_count(); ++f) {
    std::vector<Eigen::Vector3d> from, to;
    for (std::size_t m = take.face_marker_count(); m < take.measured.marker_count(); ++m) {
      if (!take.measured.valid(f, m)) continue;
      from.push_back(take.head_pose[0].inverse() * take.truth.position(0, m).cast<double>());
      to.push_back(take.measured.position(f, m).cast<double>());
    }
    Eigen::Isometry3d pose = out.empty() ? take.head_pose[0] : out.back();
    if (from.size() >= 3) {
      const RigidFit fit = fit_rigid(from, to);
      pose.linear() = fit.rotation;
      pose.translation() = fit.translation;
    }
    out.push_back(pose);
  }
  return out;
}

void stabilise() {
  for (const char* name : {"anna_happy", "anna_surprise", "ben_happy", "ben_surprise"}) {
    const SyntheticTake take = make_sample(name);
    const MarkerSequence& measured = take.measured;
    const Left reference = left_of(take.head_pose, least_squares(take));
    const auto report = [&](const char* how, const StabiliseResult& steady) {
      const Left left = left_of(take.head_pose, as_isometries(steady.poses));
      std::printf(
          "{\"take\": \"%s\", \"rigid\": \"%s\", \"markers\": %zu, \"degrees\": %.5f, "
          "\"mm\": %.5f, \"least_squares_degrees\": %.5f, \"least_squares_mm\": %.5f}\n",
          name, how, steady.shape.markers.size(), left.degrees, left.mm, reference.degrees,
          reference.mm);
    };
    report("named", stabilise_head(measured));
    report("chosen", stabilise_head(measured, find_rigid_markers(measured).markers));
  }
}

void label(const std::string& name, const MarkerSequence& take, const std::string& other_name,
           const MarkerSequence& other) {
  const test::ShuffledTake loose = test::without_labels(take, 7);
  const auto start = Clock::now();
  const LabelResult got = label_points(loose.take, learn_template(other));
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  std::size_t right = 0, wrong = 0, points = 0;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (const std::size_t m : loose.order[f]) {
      ++points;
      const std::size_t column = got.take.find(take.markers()[m].label);
      if (column == MarkerSequence::npos || !got.take.valid(f, column)) continue;
      const bool same = got.take.position(f, column) == take.position(f, m);
      right += same ? 1 : 0;
      wrong += same ? 0 : 1;
    }
  }
  std::printf(
      "{\"take\": \"%s\", \"template\": \"%s\", \"points\": %zu, \"right_percent\": %.4f, "
      "\"wrong\": %zu, \"seconds\": %.2f}\n",
      name.c_str(), other_name.c_str(), points,
      100.0 * static_cast<double>(right) / static_cast<double>(points), wrong, seconds);
}

MarkerSequence mended(const MarkerSequence& take) {
  return repair_take(take, {.spikes = false}).take;
}

void labels() {
  const auto sample = [](const std::string& name) {
    return mended(read_session(sample_folder() / (name + ".c3d")));
  };
  for (const char* who : {"anna", "ben"}) {
    const std::string happy = std::string(who) + "_happy";
    const std::string surprise = std::string(who) + "_surprise";
    label(happy, sample(happy), surprise, sample(surprise));
    label(surprise, sample(surprise), happy, sample(happy));
  }
  const auto folder = data_folder() / "c3d_face";
  if (!std::filesystem::exists(folder)) return;
  const MarkerSequence jaw = read_session(folder / "AnimFace-Jaw.c3d");
  const MarkerSequence brows = read_session(folder / "AnimFace-Eyebrows.c3d");
  label("AnimFace-Jaw", jaw, "AnimFace-Eyebrows", brows);
  label("AnimFace-Eyebrows", brows, "AnimFace-Jaw", jaw);
}

void report_swaps(const std::string& name, const MarkerSequence& take, const std::string& truth) {
  const auto found = find_label_swaps(take);
  std::string text;
  for (const LabelSwap& s : found) {
    std::string a = take.markers()[s.a].label;
    std::string b = take.markers()[s.b].label;
    if (b < a) std::swap(a, b);
    text += (text.empty() ? "" : ", ") + a + "/" + b + "@" + std::to_string(s.from);
  }
  std::printf("{\"take\": \"%s\", \"swaps\": \"%s\", \"truth\": \"%s\", \"spikes\": %zu}\n",
              name.c_str(), text.c_str(), truth.c_str(), find_spikes(take).size());
}

std::string true_swap(const SyntheticTake& take) {
  if (!take.swap) return "";
  std::string a = take.measured.markers()[take.swap->first].label;
  std::string b = take.measured.markers()[take.swap->second].label;
  if (b < a) std::swap(a, b);
  return a + "/" + b + "@" + std::to_string(take.swap->from_frame);
}

/// The samples, faces that nothing was tuned on, half of them with a swap, and the real takes.
void swaps() {
  for (const char* name : {"anna_happy", "anna_surprise", "ben_happy", "ben_surprise"}) {
    const SyntheticTake take = make_sample(name);
    report_swaps(name, take.measured, true_swap(take));
  }
  const MotionKind kinds[] = {MotionKind::talk, MotionKind::happy,  MotionKind::surprise,
                              MotionKind::jaw,  MotionKind::blinks, MotionKind::pucker_jaw};
  for (uint64_t i = 0; i < 12; ++i) {
    const char* who = i % 4 < 2 ? "anna" : "ben";
    TakeOptions options;
    options.short_gaps = 66 * (1 + i % 2);
    options.long_gaps = 8;
    options.head_degrees = 6;
    options.head_mm = 25;
    options.head_rig = true;
    options.label_swap = i % 2 == 1;
    options.seed = 100 + i;
    const SyntheticTake take = make_take(sample_face(who), sample_layout(who),
                                         vary(make_motion(kinds[i % 6]), i), options);
    report_swaps("generated " + std::to_string(i), take.measured, true_swap(take));
  }
  const auto folder = data_folder() / "c3d_face";
  if (!std::filesystem::exists(folder)) return;
  for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows", "Facial-Sing"}) {
    report_swaps(name, read_session(folder / (std::string(name) + ".c3d")), "");
  }
}

/// RMS distance from the truth: of all measured samples, and of those in `spikes`.
struct Off {
  double all_mm = 0.0, in_spikes_mm = 0.0;
};

Off off_from(const MarkerSequence& take, const MarkerSequence& truth, const MarkerSequence& seen,
             const std::vector<Spike>& spikes) {
  double all = 0.0, count = 0.0, there = 0.0, spiky = 0.0;
  for (std::size_t f = 0; f < truth.frame_count(); ++f) {
    for (std::size_t m = 0; m < truth.marker_count(); ++m) {
      if (!seen.valid(f, m) || !take.valid(f, m)) continue;
      all += (take.position(f, m) - truth.position(f, m)).squaredNorm();
      count += 1.0;
    }
  }
  for (const Spike& s : spikes) {  // none: 0
    for (std::size_t f = s.frames.begin; f < s.frames.end; ++f) {
      there += (take.position(f, s.marker) - truth.position(f, s.marker)).squaredNorm();
      spiky += 1.0;
    }
  }
  return {std::sqrt(all / count), std::sqrt(there / std::max(spiky, 1.0))};
}

void report_spikes(const std::string& name, const MarkerSequence& take, const MarkerSequence& truth,
                   double share, uint32_t seed) {
  const SpikyTake spiky = with_spikes(take, share, seed);
  const CleanResult cleaned = clean_take(spiky.take);
  const RepairResult repaired = repair_take(spiky.take);
  std::size_t small = 0, small_missed = 0;
  const std::size_t missed = not_among(spiky.spikes, repaired.spikes);
  for (const Spike& s : spiky.spikes) {
    if (s.deviation_mm > 5.0) continue;
    ++small;
    small_missed += not_among({s}, repaired.spikes);
  }
  const Off before = off_from(spiky.take, truth, take, spiky.spikes);
  const Off after = off_from(cleaned.take, truth, take, spiky.spikes);
  const Off clean = off_from(take, truth, take, spiky.spikes);
  std::printf(
      "{\"take\": \"%s\", \"share_percent\": %.2f, \"put\": %zu, \"missed\": %zu, \"small\": %zu, "
      "\"small_missed\": %zu, \"found\": %zu, \"false\": %zu, \"swaps\": %zu, \"jumps\": %zu, "
      "\"before_mm\": %.4f, \"after_mm\": %.4f, \"without_spikes_mm\": %.4f, "
      "\"there_before_mm\": %.4f, \"there_after_mm\": %.4f}\n",
      name.c_str(), 100.0 * share, spiky.spikes.size(), missed, small, small_missed,
      repaired.spikes.size(), not_among(repaired.spikes, spiky.spikes), repaired.swaps.size(),
      repaired.jumps.size() + repaired.strays.size(), before.all_mm, after.all_mm, clean.all_mm,
      before.in_spikes_mm, after.in_spikes_mm);
}

/// Every `step`th frame only: the same motion, faster.
MarkerSequence faster(const MarkerSequence& take, std::size_t step) {
  MarkerSequence out((take.frame_count() + step - 1) / step, take.markers(), take.rate_hz);
  std::ranges::fill(out.flags(), uint8_t{0});
  for (std::size_t f = 0; f < out.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      out.position(f, m) = take.position(step * f, m);
      out.flags()[out.sample(f, m)] = take.flags()[take.sample(step * f, m)];
      out.residuals()[out.sample(f, m)] = 0.0F;
      out.camera_masks()[out.sample(f, m)] = 0;
    }
  }
  return out;
}

/// Motion of all kinds without a spike, at two and three times its speed too.
void clean_motion() {
  const MotionKind kinds[] = {MotionKind::happy, MotionKind::surprise, MotionKind::jaw,
                              MotionKind::brows, MotionKind::blinks,   MotionKind::pucker,
                              MotionKind::talk,  MotionKind::puff,     MotionKind::pucker_jaw};
  for (std::size_t i = 0; i < 9; ++i) {
    TakeOptions options;
    options.short_gaps = 66;
    options.head_degrees = 6;
    options.head_mm = 25;
    options.head_rig = true;
    options.rate_hz = i % 2 == 0 ? 60 : 120;
    options.seed = 300 + i;
    const SyntheticTake take = make_take(sample_face(i % 2 == 0 ? "ben" : "anna"),
                                         sample_layout(i % 2 == 0 ? "ben" : "anna"),
                                         vary(make_motion(kinds[i]), i), options);
    for (const std::size_t step : {std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
      report_spikes(take.motion.name + " x" + std::to_string(step), faster(take.measured, step),
                    faster(take.truth, step), 0.0, 1);
    }
  }
  const auto folder = data_folder() / "c3d_face";
  if (!std::filesystem::exists(folder)) return;
  for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows"}) {
    const MarkerSequence take = read_session(folder / (std::string(name) + ".c3d"));
    for (const std::size_t step : {std::size_t{2}, std::size_t{3}, std::size_t{4}}) {
      const MarkerSequence fast = faster(take, step);
      report_spikes(std::string(name) + " x" + std::to_string(step), fast, fast, 0.0, 1);
    }
  }
}

/// Spikes at known places, few and many.
void spikes() {
  clean_motion();
  const auto folder = data_folder() / "c3d_face";
  for (const double share : {0.0, 0.002, 0.01}) {
    const auto seed = static_cast<uint32_t>(1 + 1000 * share);
    for (const char* name : {"anna_happy", "anna_surprise", "ben_happy"}) {
      const SyntheticTake take = make_sample(name);
      report_spikes(name, take.measured, take.truth, share, seed);
    }
    if (!std::filesystem::exists(folder)) continue;
    for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows"}) {
      const MarkerSequence take = read_session(folder / (std::string(name) + ".c3d"));
      report_spikes(name, take, take, share, seed);
    }
  }
}

void report_strays(const std::string& name, const MarkerSequence& take, uint32_t seed) {
  constexpr std::size_t count = 20;
  const StrayTake put = with_strays(take, count, seed);
  const std::vector<Stray> found = repair_take(put.take).strays;
  const auto same = [](const Stray& a, const Stray& b) {
    return a.marker == b.marker && a.frames.begin < b.frames.end && b.frames.begin < a.frames.end;
  };
  std::size_t right = 0, owned = 0, given = 0, wrong_owner = 0, wrong = 0;
  for (const Stray& s : put.strays) {
    const auto hit = std::ranges::find_if(found, [&](const Stray& f) { return same(s, f); });
    owned += s.owner ? 1 : 0;
    if (hit == found.end()) continue;
    ++right;
    given += s.owner && hit->owner == s.owner ? 1 : 0;
    wrong_owner += hit->owner && hit->owner != s.owner ? 1 : 0;
  }
  for (const Stray& f : found) {
    wrong += std::ranges::none_of(put.strays, [&](const Stray& s) { return same(s, f); }) ? 1 : 0;
  }
  const RepairResult clean = repair_take(with_islands(take, count, seed));
  std::printf(
      "{\"take\": \"%s\", \"put\": %zu, \"found\": %zu, \"of_others\": %zu, \"given_right\": %zu, "
      "\"given_wrong\": %zu, \"false\": %zu, \"false_islands\": %zu, \"false_swaps\": %zu}\n",
      name.c_str(), put.strays.size(), right, owned, given, wrong_owner, wrong, clean.strays.size(),
      clean.swaps.size());
}

/// Stretches between two gaps that hold another marker or a reflection, and as many that are right.
void strays() {
  for (const uint32_t seed : {1U, 2U, 3U}) {
    for (const char* name : {"anna_happy", "anna_surprise", "ben_happy"}) {
      report_strays(name, make_sample(name).measured, seed);
    }
    const auto folder = data_folder() / "c3d_face";
    if (!std::filesystem::exists(folder)) continue;
    for (const char* name : {"AnimFace-Jaw", "AnimFace-Eyebrows"}) {
      report_strays(name, read_session(folder / (std::string(name) + ".c3d")), seed);
    }
  }
}

}  // namespace
}  // namespace kinemesh::test

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "speed") kinemesh::test::speed();
  if (what == "stabilise") kinemesh::test::stabilise();
  if (what == "labels") kinemesh::test::labels();
  if (what == "swaps") kinemesh::test::swaps();
  if (what == "spikes") kinemesh::test::spikes();
  if (what == "strays") kinemesh::test::strays();
}
