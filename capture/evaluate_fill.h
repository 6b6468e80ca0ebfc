// How well each method fills gaps in a given take: known stretches are removed, filled and
// compared with what was there.
#pragma once

#include <string>
#include <vector>

#include "capture/gap_fill.h"
#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

struct EvaluateFillOptions {
  int markers = 5;     ///< that get one gap each, in every trial
  double gap_s = 0.5;  ///< length of a gap
  int trials = 64;
  double noise_mm = 0.0;  ///< normal noise added to every coordinate of the take before stretches
                          ///< are removed; errors are measured against the take without it
  bool repair = true;  ///< spikes are taken out and exchanged labels put right first, as they are
                       ///< before filling: what stands for the truth must not be wrong itself
  FillEffort effort = FillEffort::automatic;  ///< of auto
  std::vector<std::string> methods = {"auto",    "linear", "cubic", "quintic",
                                      "pattern", "rigid",  "pca"};

  void declare(ParameterSet& p);
  /// Throws UsageError, also for an unknown method.
  void validate() const;
};

/// Errors of one method over all gaps. The error of a gap is the root mean square distance, in 3D,
/// between the filled and the true positions.
struct FillScore {
  FillMethod method = FillMethod::automatic;
  std::size_t gaps = 0;        ///< filled by the method itself
  std::size_t not_filled = 0;  ///< that it cannot fill (too few companions…)
  double median_mm = 0.0;      ///< over gaps; NaN when it fills none
  double percentile_90_mm = 0.0;
  double maximum_mm = 0.0;
  double within_band_percent = 0.0;  ///< share of the samples whose true position lies within the
                                     ///< 90 % band; NaN for methods other than auto. Without
                                     ///< noise_mm the removed measurements stand for the truth, and
                                     ///< the band is widened by their own noise (noise_variance()).
  double band_width_mm = 0.0;        ///< mean radius of that band; NaN likewise
  double ms_per_gap = 0.0;           ///< wall time over gaps, on all threads together
};

struct EvaluateFillResult {
  std::vector<FillScore> scores;  ///< in the order of the options
  std::size_t gap_frames = 0;
  std::size_t candidates = 0;         ///< markers that are measured for long enough
  std::vector<std::string> repaired;  ///< what was put right before, one sentence each
  std::vector<std::string> warnings;  ///< full sentences, also sent to ctx
};

/// Gaps begin anywhere inside the take (never at its ends) where the marker is measured throughout
/// and on both sides; they are the same for every method and depend on ctx.seed() alone. Gaps that
/// the take has of its own stay. Splines fill gaps of any length here. Throws NoResultError when
/// too few markers are measured for long enough.
EvaluateFillResult evaluate_fill(const MarkerSequence& recorded,
                                 const EvaluateFillOptions& options = {},
                                 const RunContext& ctx = {});

/// The table for a person: one line a method.
std::string evaluate_fill_text(const EvaluateFillResult& result);
/// {"gap_frames", "trials"…, "methods": [{"method", "median_mm", …}]}: the fields of FillScore
/// under their names; null where a figure does not exist.
std::string evaluate_fill_json(const EvaluateFillResult& result, const EvaluateFillOptions& options,
                               const std::string& file);

}  // namespace kinemesh
