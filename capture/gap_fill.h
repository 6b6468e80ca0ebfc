// Gap filling: estimates the samples that were not measured, with an uncertainty for each.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "capture/gaps.h"
#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

enum class FillMethod {
  automatic,  ///< Gaussian process on the other markers and time: the most accurate
  linear,     ///< straight line between the ends of the gap
  cubic,      ///< natural cubic spline
  quintic,    ///< natural quintic spline
  pattern,    ///< the motion of a donor marker
  rigid,      ///< three or more companions taken as a rigid body
  pca,        ///< correlations between markers (Gløersen & Federolf 2016)
  hold,       ///< the nearest measured position: what is left for gaps at the ends of a take in
              ///< which nothing else is known; not to be chosen
};

/// "auto", "linear", …: the words of options and reports.
std::string_view name_of(FillMethod method);

/// How long `automatic` may take over a gap.
enum class FillEffort {
  automatic,  ///< full for up to 100 gaps, fast for more
  full,       ///< about 11 ms
  fast,       ///< about 1 ms
};

struct GapFillOptions {
  FillMethod method = FillMethod::automatic;
  FillEffort effort = FillEffort::automatic;
  double max_gap_s = 0.2;  ///< longest gap that linear, cubic and quintic fill
  std::string donor;       ///< pattern: label; empty: the nearest marker seen throughout
  std::vector<std::string> companions;  ///< rigid: labels; empty: the nearest ones seen throughout
  bool fill_rest = true;  ///< what the method cannot fill is filled by `automatic`; else it is left

  void declare(ParameterSet& p);
  /// Throws UsageError, also for a donor or companions that the method does not use, and for
  /// fewer than three companions.
  void validate() const;
};

/// One gap that was filled.
struct Fill {
  std::size_t marker = 0;  ///< index into markers()
  FrameRange frames;
  FillMethod method = FillMethod::automatic;  ///< what filled it
  double mean_sd_mm = 0.0;                    ///< mean of its samples' uncertainty
  double max_sd_mm = 0.0;                     ///< the largest of them
};

struct GapFillResult {
  /// The take with all estimated samples valid, flagged `filled` and finite; measured samples are
  /// untouched. uncertainty() is the standard deviation of one coordinate in mm, the same along
  /// x, y and z: 90 % of the true positions lie within fill_band_90 × it.
  MarkerSequence take;
  std::vector<Fill> fills;               ///< by marker, then by time
  std::vector<std::size_t> never_valid;  ///< markers without one valid sample: left as they are
  std::vector<std::string> warnings;     ///< full sentences, also sent to ctx
};

/// Radius of the ball that holds 90 % of an isotropic normal distribution in three dimensions, in
/// standard deviations of one coordinate.
inline constexpr double fill_band_90 = 2.500277;

/// Fills every gap of every marker that is valid at least once, at the ends of the take too. A
/// valid sample that is not finite counts as missing. Throws UsageError for options that fit
/// neither their ranges nor the take (a donor that does not exist).
GapFillResult fill_gaps(const MarkerSequence& take, const GapFillOptions& options = {},
                        const RunContext& ctx = {});

}  // namespace kinemesh
