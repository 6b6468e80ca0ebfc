// Repair of recorded trajectories: spikes are taken out (gap filling closes the hole), labels that
// were exchanged are put right. What was done is a list of editing steps, so that each can be taken
// back.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/edit_list.h"
#include "capture/gaps.h"
#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

struct RepairOptions {
  bool spikes = true;
  double spike_mm = 1.0;     ///< smaller deviations are no spikes
  double spike_ratio = 5.0;  ///< deviations below this many robust standard deviations are none
  double spike_length_s = 0.035;  ///< longer ones are no spikes
  bool swaps = true;
  bool strays = true;  ///< give stretches that are another marker's to it, take out nobody's

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// A marker left its path for a moment and came back.
struct Spike {
  std::size_t marker = 0;  ///< index into markers()
  FrameRange frames;
  double deviation_mm = 0.0;  ///< the largest distance from the path
};

/// Two markers exchanged their labels. Where those of three or more went round (the first at the
/// place of the second, …, the last at that of the first), there is one for each marker but the
/// first, one behind the other: together they undo it.
struct LabelSwap {
  std::size_t a = 0, b = 0;  ///< indices into markers()
  std::size_t from = 0;      ///< 0-based: first frame with the wrong labels
  /// The first right one again; without it they are wrong to the end, or until the next swap of the
  /// same two.
  std::optional<std::size_t> until;
  double error_mm = 0.0;   ///< mean distance from where the labels should be, as recorded
  double mended_mm = 0.0;  ///< the same after the exchange
  std::size_t of = 2;      ///< labels that went round
};

/// How often labels were exchanged; a round of three or more counts once.
std::size_t count_swaps(const std::vector<LabelSwap>& swaps);

/// A marker goes elsewhere within one frame and stays there, and no other one took its place: its
/// label is wrong before or after. Which one, a person must say.
struct Jump {
  std::size_t marker = 0;  ///< index into markers()
  std::size_t frame = 0;   ///< 0-based: the first one elsewhere
  double size_mm = 0.0;    ///< off from where its neighbours say
};

/// A stretch of a trajectory that is not its marker's: it begins and ends with a gap or a jump, and
/// lies elsewhere than the neighbours say, before and behind.
struct Stray {
  std::size_t marker = 0;  ///< index into markers()
  FrameRange frames;
  double off_mm = 0.0;  ///< the largest distance from the marker's place
  std::optional<std::size_t>
      owner;  ///< whose place it is, not seen in these frames; none: nobody's
};

struct RepairResult {
  MarkerSequence take;  ///< spikes invalid, labels right
  std::vector<Spike> spikes;
  std::vector<LabelSwap> swaps;
  std::vector<Stray> strays;
  std::vector<Jump> jumps;        ///< left as they are
  EditList edits;                 ///< the same as steps, in the order applied
  std::vector<std::string> done;  ///< one sentence each, with frame numbers as in the file
};

/// Spikes: up to `spike_length_s` in which every sample is farther than spike_mm × frames and
/// spike_ratio × the robust standard deviation (1.4826 × median) of the acceleration (as the
/// distance from the mean of the samples beside it), of the marker and of the spike's surroundings,
/// from the cubic through the samples around, while these fit each other without the spike and the
/// path goes on where it was. Where one sample alone is left on a side, the neighbours must
/// disagree as well; where the path ends, the samples must be off both from where it leads and from
/// where the neighbours go. Taken out before swaps are sought, except where two markers are at each
/// other's place, and again behind.
/// Swaps: a marker jumps, or comes back from a gap, farther from where its neighbours say it should
/// be than 0.35 × the distance to the nearest marker and 3 × what is usual for it from one frame to
/// the next, to where another one should be, and that other one likewise to its place, or on to a
/// third one's, and so on round.
/// Strays: see there; up to 1.5 s, off by more than makes a jump and twice what 95 % of the take's
/// stretches of that length keep of where the neighbours' rigid motion leads, three times when they
/// are nobody's. Given to the marker that was not seen and should be there, or taken out.
/// When labels are exchanged once, in the first third of the take, the frames before have the wrong
/// ones: those that hold for longer are right.
/// Markers of the body alone are looked at; filled samples are not.
RepairResult repair_take(const MarkerSequence& take, const RepairOptions& options = {},
                         const RunContext& ctx = {});

std::vector<Spike> find_spikes(const MarkerSequence& take, const RepairOptions& options = {},
                               const RunContext& ctx = {}, bool at_ends = true);
std::vector<Stray> find_strays(const MarkerSequence& take, const RunContext& ctx = {});
/// `jumps`: those that no swap explains are added there.
std::vector<LabelSwap> find_label_swaps(const MarkerSequence& take, const RunContext& ctx = {},
                                        std::vector<Jump>* jumps = nullptr);

}  // namespace kinemesh
