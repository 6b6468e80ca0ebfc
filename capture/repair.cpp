#include "capture/repair.h"

#include <algorithm>
#include <optional>

#include "capture/edit/operation.h"
#include "capture/edit/timeline.h"
#include "capture/formats/table_text.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// The label by which an editing step finds this marker again.
std::string name_in(const MarkerSequence& take, std::size_t m) {
  return qualified_label(take.markers()[m].subject, take.markers()[m].label);
}

std::string frame_number(const MarkerSequence& take, std::size_t f) {
  return std::to_string(take.first_frame + static_cast<int64_t>(f));
}

std::string frames_said(const std::string& from, const std::string& to) {
  if (from == to) return "frame " + from;
  return "frames " + from + " to " + to;
}

void apply(const LabelSwap& swap, RepairResult& result) {
  const MarkerSequence& take = result.take;
  const std::string a = name_in(take, swap.a);
  const std::string b = name_in(take, swap.b);
  const std::string from = frame_number(take, swap.from);
  const std::size_t end = swap.until.value_or(take.frame_count());
  const std::string to = swap.until ? frame_number(take, end - 1) : "0";  // 0: the last one
  result.edits.steps.push_back(
      make_edit("swap", {{"a", {a}}, {"b", {b}}, {"from", {from}}, {"to", {to}}}));
  swap_samples(result.take, swap.a, swap.b, {swap.from, end});
  result.done.push_back(
      "exchanged " + a + " and " + b +
      (swap.until ? " in " + frames_said(from, to) : " from frame " + from + " on") +
      ": they were " + format_fixed(swap.error_mm, 1) +
      " mm from where their neighbours say, now " + format_fixed(swap.mended_mm, 1) + " mm");
}

void invalidate(MarkerSequence& take, std::size_t m, const FrameRange& frames) {
  for (std::size_t f = frames.begin; f < frames.end; ++f) {
    const std::size_t s = take.sample(f, m);
    take.flags()[s] = 0;
    take.residuals()[s] = 0.0F;
    take.camera_masks()[s] = 0;
  }
}

void apply(const Spike& spike, RepairResult& result) {
  MarkerSequence& take = result.take;
  const std::string label = name_in(take, spike.marker);
  const std::string from = frame_number(take, spike.frames.begin);
  const std::string to = frame_number(take, spike.frames.end - 1);
  result.edits.steps.push_back(
      make_edit("delete", {{"markers", {label}}, {"from", {from}}, {"to", {to}}}));
  invalidate(take, spike.marker, spike.frames);
  result.done.push_back("took out a spike of " + label + " of " +
                        format_fixed(spike.deviation_mm, 1) + " mm in " + frames_said(from, to));
}

/// May the samples be given to their owner: is it measured in none of these frames?
bool is_free(const MarkerSequence& take, const Stray& stray) {
  for (std::size_t f = stray.frames.begin; f < stray.frames.end; ++f) {
    if (take.valid(f, stray.marker) && take.valid(f, *stray.owner)) return false;
  }
  return true;
}

void apply(const Stray& stray, RepairResult& result) {
  MarkerSequence& take = result.take;
  const std::string label = name_in(take, stray.marker);
  const std::string from = frame_number(take, stray.frames.begin);
  const std::string to = frame_number(take, stray.frames.end - 1);
  const std::string where = " of " + label + ", " + frames_said(from, to) + ", " +
                            format_fixed(stray.off_mm, 1) + " mm from its place";
  result.strays.push_back(stray);
  if (stray.owner) {
    const std::string owner = name_in(take, *stray.owner);
    result.edits.steps.push_back(make_edit(
        "move", {{"marker", {label}}, {"into", {owner}}, {"from", {from}}, {"to", {to}}}));
    for (std::size_t f = stray.frames.begin; f < stray.frames.end; ++f) {
      if (!take.valid(f, stray.marker)) continue;
      copy_sample(take, take.sample(f, stray.marker), take, take.sample(f, *stray.owner));
      invalidate(take, stray.marker, {f, f + 1});
    }
    result.done.push_back("gave the stretch" + where + " to " + owner);
    return;
  }
  result.edits.steps.push_back(
      make_edit("delete", {{"markers", {label}}, {"from", {from}}, {"to", {to}}}));
  invalidate(take, stray.marker, stray.frames);
  result.done.push_back("took out the stretch" + where + ", where no marker was missing");
}

/// Nobody's first, then each to its owner when that one's own strays are gone from there.
void repair_strays(RepairResult& result, const RunContext& ctx) {
  std::vector<Stray> left;
  for (const Stray& stray : find_strays(result.take, ctx)) {
    if (stray.owner) {
      left.push_back(stray);
    } else {
      apply(stray, result);
    }
  }
  while (!left.empty()) {
    auto next = std::ranges::find_if(left, [&](const Stray& s) { return is_free(result.take, s); });
    if (next == left.end()) {  // in each other's way
      next = left.begin();
      next->owner.reset();
    }
    apply(*next, result);
    left.erase(next);
  }
  std::erase_if(result.jumps, [&](const Jump& jump) {
    return std::ranges::any_of(result.strays, [&](const Stray& s) {
      return s.marker == jump.marker && s.frames.begin <= jump.frame && jump.frame <= s.frames.end;
    });
  });
}

/// Where the marker of a spike would be if its path went straight from the sample before to the one
/// behind, where both are seen.
std::optional<Eigen::Vector3f> bridged(const MarkerSequence& take, std::size_t m,
                                       const FrameRange& frames, std::size_t f) {
  if (frames.begin == 0 || frames.end >= take.frame_count()) return std::nullopt;
  if (!take.valid(frames.begin - 1, m) || !take.valid(frames.end, m)) return std::nullopt;
  const float share =
      static_cast<float>(f - frames.begin + 1) / static_cast<float>(frames.end - frames.begin + 1);
  return (1.0F - share) * take.position(frames.begin - 1, m) + share * take.position(frames.end, m);
}

/// The marker is where another one should be, which left its path in the same frame: labels were
/// exchanged for a moment, and nothing is to be thrown away.
bool exchanged(const MarkerSequence& take, const Spike& spike, const std::vector<Spike>& all) {
  constexpr double close = 0.4;
  const std::size_t f = spike.frames.begin;
  return std::ranges::any_of(all, [&](const Spike& other) {
    if (other.marker == spike.marker || f < other.frames.begin || f >= other.frames.end) {
      return false;
    }
    const auto there = bridged(take, other.marker, other.frames, f);
    return there && (take.position(f, spike.marker) - *there).norm() < close * spike.deviation_mm;
  });
}

/// Spikes are taken out before labels are compared, lest they be taken for exchanges; and again
/// afterwards, when the paths are in order.
void repair_spikes(RepairResult& result, bool labels_may_be_wrong, const RepairOptions& options,
                   const RunContext& ctx) {
  const std::vector<Spike> found = find_spikes(result.take, options, ctx, !labels_may_be_wrong);
  std::vector<Spike> out;
  for (const Spike& spike : found) {
    if (!labels_may_be_wrong || !exchanged(result.take, spike, found)) out.push_back(spike);
  }
  for (const Spike& spike : out) apply(spike, result);
  result.spikes.insert(result.spikes.end(), out.begin(), out.end());
}

}  // namespace

void RepairOptions::declare(ParameterSet& p) {
  p.group("repair", "Repair");
  p.flag("spikes", spikes, "take out samples that leave the marker's path for a moment");
  p.number("spike-size", spike_mm,
           {.unit = "mm",
            .min = 0.0,
            .max = 1000.0,
            .help = "smaller deviations are no spikes; this for each frame of the spike"});
  p.number("spike-ratio", spike_ratio,
           {.min = 1.0,
            .max = 1000.0,
            .help = "deviations below this many robust standard deviations are no spikes"});
  p.number("spike-length", spike_length_s,
           {.unit = "s", .min = 0.0, .max = 0.5, .help = "longer deviations are no spikes"});
  p.flag("swaps", swaps, "put labels right that markers exchanged");
  p.flag("strays", strays,
         "give stretches between two breaks that lie at another marker's place to it, and take out "
         "those that lie at nobody's");
}

RepairResult repair_take(const MarkerSequence& take, const RepairOptions& options,
                         const RunContext& ctx) {
  options.validate();
  RepairResult result;
  result.take = take;
  if (options.spikes && options.swaps) {
    repair_spikes(result, true, options, ctx.part(0.0, 0.3, "looking for spikes"));
  }
  if (options.swaps) {
    result.swaps =
        find_label_swaps(result.take, ctx.part(0.3, 0.6, "looking for label swaps"), &result.jumps);
    for (const LabelSwap& swap : result.swaps) apply(swap, result);
  }
  if (options.spikes) {
    repair_spikes(result, false, options, ctx.part(0.6, 0.9, "looking for spikes"));
    std::erase_if(result.jumps, [&](const Jump& jump) {  // it came back
      return std::ranges::any_of(result.spikes, [&](const Spike& s) {
        return s.marker == jump.marker && s.frames.begin <= jump.frame &&
               jump.frame <= s.frames.end;
      });
    });
  }
  if (options.strays) repair_strays(result, ctx.part(0.9, 1.0, "looking for stray stretches"));
  return result;
}

}  // namespace kinemesh
