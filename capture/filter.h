// Smoothing of trajectories: every run of valid samples on its own, never across a gap that was not
// filled.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

enum class FilterMethod {
  none,
  butterworth,     ///< low-pass, forwards and backwards: no delay
  savitzky_golay,  ///< local polynomials (Savitzky & Golay 1964)
  moving_average,
  median,
};

/// "none", "butterworth", "savitzky-golay", …
std::string_view name_of(FilterMethod method);

struct FilterOptions {
  FilterMethod method = FilterMethod::butterworth;
  double cutoff_hz = 0.0;  ///< butterworth: of one pass; 0: by residual analysis, marker by marker
  int order = 2;           ///< butterworth: of one pass; both together fall off twice as steeply
  int window = 7;          ///< the others: frames, odd
  int degree = 3;          ///< savitzky_golay: of the polynomials, below the window

  void declare(ParameterSet& p);
  /// Throws UsageError, also for an even window or one that does not exceed the degree.
  void validate() const;
};

struct FilterResult {
  MarkerSequence take;             ///< flags and residuals as they were
  std::vector<double> cutoffs_hz;  ///< per marker, of butterworth; NaN where nothing was filtered
  std::size_t runs = 0;            ///< that were filtered
  std::size_t short_runs = 0;      ///< left as they are: shorter than three samples
  double rms_change_mm = 0.0;      ///< root mean square distance by which samples moved
  std::vector<std::string> warnings;  ///< full sentences, also sent to ctx
};

/// Filters the points of the body (markers, unlabelled and virtual points). Throws UsageError for
/// options out of range or a cut-off at or above half of the rate.
FilterResult filter_take(const MarkerSequence& take, const FilterOptions& options = {},
                         const RunContext& ctx = {});

/// One run of equidistant samples, in place, as the functions of SciPy do it:
/// butterworth: sosfiltfilt(butter(order, cutoff, output="sos", fs=rate_hz)) with odd padding, as
/// long as the run allows; savitzky_golay: savgol_filter(mode="interp"); moving_average:
/// uniform_filter1d(mode="nearest"); median: median_filter(mode="nearest"). A run shorter than the
/// window of savitzky_golay is filtered with the longest odd window that fits it, or left.
/// options.cutoff_hz must be given.
void filter_series(std::span<double> values, double rate_hz, const FilterOptions& options);

/// The cut-off that residual analysis suggests (Winter, Biomechanics and Motor Control of Human
/// Movement, 2009, sec. 3.4.4): the residual of low-passed runs is taken as pure noise where it
/// falls on a line with frequency; that line's value at 0 Hz is the residual to accept. `runs`:
/// equidistant samples each. At least 1 Hz and at most 0.45 × rate_hz; that when the runs are too
/// short to tell or hold no noise.
double suggest_cutoff(std::span<const std::vector<double>> runs, double rate_hz, int order = 2);

}  // namespace kinemesh
