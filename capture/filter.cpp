#include "capture/filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "capture/filter/butterworth.h"
#include "capture/filter/windows.h"
#include "capture/gaps.h"
#include "capture/idle_options.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t shortest_run = 3;  // frames; below there is nothing to smooth
constexpr double least_cutoff_hz = 1.0;
constexpr double highest_share = 0.45;  // of the rate

std::vector<FrameRange> runs_of(const MarkerSequence& take, std::size_t marker) {
  std::vector<FrameRange> runs;
  const auto usable = [&](std::size_t f) {
    return take.valid(f, marker) && take.position(f, marker).allFinite();
  };
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    if (!usable(f)) continue;
    FrameRange run{f, f};
    while (run.end < take.frame_count() && usable(run.end)) ++run.end;
    runs.push_back(run);
    f = run.end;
  }
  return runs;
}

std::vector<double> coordinate(const MarkerSequence& take, std::size_t marker, FrameRange run,
                               Eigen::Index axis) {
  std::vector<double> values;
  values.reserve(run.size());
  for (std::size_t f = run.begin; f < run.end; ++f) {
    values.push_back(take.position(f, marker)[axis]);
  }
  return values;
}

/// What filtering one marker did.
struct MarkerTally {
  double cutoff_hz = std::numeric_limits<double>::quiet_NaN();
  double noise_mm = 0.0;  ///< standard deviation, 3D
  double squares = 0.0;
  std::size_t samples = 0, runs = 0, short_runs = 0;
};

/// Per axis the runs' values.
using Coordinates = std::array<std::vector<std::vector<double>>, 3>;

/// Standard deviation of what changes from sample to sample: the fourth difference of equidistant
/// samples, which motion hardly has, by its median.
double noise_of(std::span<const std::vector<double>> runs) {
  std::vector<double> sizes;
  for (const std::vector<double>& x : runs) {
    for (std::size_t i = 4; i < x.size(); ++i) {
      sizes.push_back(std::abs(x[i - 4] - 4.0 * x[i - 3] + 6.0 * x[i - 2] - 4.0 * x[i - 1] + x[i]));
    }
  }
  if (sizes.empty()) return 0.0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  constexpr double of_normal = 0.67448975;  // the median
  constexpr double gain = 70.0;             // 1² + 4² + 6² + 4² + 1²
  return *middle / of_normal / std::sqrt(gain);
}

/// The largest RMS, over stretches of a quarter of a second, of what a cut-off takes away.
double worst_stretch(std::span<const std::vector<double>> runs, double rate_hz, int order,
                     double cutoff_hz) {
  constexpr double stretch_s = 0.25;
  const auto length = static_cast<std::size_t>(std::max(5.0, std::round(stretch_s * rate_hz)));
  const auto sections = filter::butterworth_sections(order, cutoff_hz, rate_hz);
  double worst = 0.0;
  for (const std::vector<double>& run : runs) {
    std::vector<double> smooth = run;
    filter::filter_both_ways(sections, order, smooth);
    double squares = 0.0;
    const auto removed = [&](std::size_t i) { return std::pow(run[i] - smooth[i], 2); };
    for (std::size_t i = 0; i < run.size(); ++i) {
      squares += removed(i);
      if (i >= length) squares -= removed(i - length);
      if (i + 1 >= length) worst = std::max(worst, squares / static_cast<double>(length));
    }
  }
  return std::sqrt(std::max(0.0, worst));
}

/// What residual analysis suggests rests on the whole take, in which a blink weighs nothing. It is
/// raised until no quarter of a second loses more than noise. Below `least_hz` next to no noise is
/// left to be gained, and what the last samples are off by would be smeared over many frames.
double cutoff_for(const Coordinates& series, double rate_hz, const FilterOptions& options) {
  constexpr double most = 1.6;  // × the noise: its own RMS over such a stretch hardly exceeds that
  constexpr double step = 1.1;
  constexpr double least_hz = 6.0;
  if (options.cutoff_hz > 0.0) return options.cutoff_hz;
  std::vector<std::vector<double>> all;
  for (const auto& axis : series) all.insert(all.end(), axis.begin(), axis.end());
  const double highest = highest_share * rate_hz;
  double cutoff =
      std::max(std::min(least_hz, highest), suggest_cutoff(all, rate_hz, options.order));
  for (const auto& axis : series) {
    const double accepted = most * noise_of(axis);
    while (cutoff < highest && worst_stretch(axis, rate_hz, options.order, cutoff) > accepted) {
      cutoff = std::min(highest, cutoff * step);
    }
  }
  return cutoff;
}

MarkerTally filter_marker(MarkerSequence& take, std::size_t marker, FilterOptions options) {
  MarkerTally tally;
  const std::vector<FrameRange> runs = runs_of(take, marker);
  Coordinates series;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const FrameRange run : runs) {
      series[axis].push_back(coordinate(take, marker, run, static_cast<Eigen::Index>(axis)));
    }
    tally.noise_mm = std::hypot(tally.noise_mm, noise_of(series[axis]));
  }
  if (options.method == FilterMethod::butterworth && !runs.empty()) {
    options.cutoff_hz = cutoff_for(series, take.rate_hz, options);
    tally.cutoff_hz = options.cutoff_hz;
  }
  for (const FrameRange run : runs) {
    if (run.size() < shortest_run) {
      ++tally.short_runs;
      continue;
    }
    ++tally.runs;
    tally.samples += run.size();
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      std::vector<double> values = coordinate(take, marker, run, axis);
      filter_series(values, take.rate_hz, options);
      for (std::size_t i = 0; i < values.size(); ++i) {
        float& place = take.position(run.begin + i, marker)[axis];
        tally.squares += (values[i] - place) * (values[i] - place);
        place = static_cast<float>(values[i]);
      }
    }
  }
  return tally;
}

/// Names the markers whose samples moved by more than noise explains.
void warn_of_lost_motion(const MarkerSequence& take, const std::vector<MarkerTally>& tallies,
                         FilterResult& result, const RunContext& ctx) {
  constexpr double clearly = 1.5;
  constexpr double least_mm = 0.05;  // of all three coordinates; below, nothing visible is lost
  std::vector<std::pair<double, std::size_t>> lost;
  for (std::size_t m = 0; m < tallies.size(); ++m) {
    const MarkerTally& t = tallies[m];
    if (t.samples == 0) continue;
    const double change = std::sqrt(t.squares / static_cast<double>(t.samples));
    if (change > std::max(least_mm, clearly * t.noise_mm)) {
      lost.emplace_back(change, m);
    }
  }
  if (lost.empty()) return;
  const auto& [change, worst] = *std::ranges::max_element(lost);
  result.warnings.push_back(
      "Smoothing moved " + count_of(lost.size(), "marker") +
      " by more than noise explains, most of all " + take.markers()[worst].label + " (" +
      format_fixed(change, 2) + " mm RMS, noise " + format_fixed(tallies[worst].noise_mm, 2) +
      " mm): fast motion such as a blink is lost with it. Smooth less (a higher --cutoff, a "
      "shorter --window).");
  ctx.warn(result.warnings.back());
}

/// RMS of what a cut-off takes away.
double residual(std::span<const std::vector<double>> runs, double rate_hz, int order,
                double cutoff_hz) {
  const auto sections = filter::butterworth_sections(order, cutoff_hz, rate_hz);
  double squares = 0.0;
  double count = 0.0;
  for (const std::vector<double>& run : runs) {
    std::vector<double> smooth = run;
    filter::filter_both_ways(sections, order, smooth);
    for (std::size_t i = 0; i < run.size(); ++i) {
      squares += (run[i] - smooth[i]) * (run[i] - smooth[i]);
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

/// Intercept at 0 Hz of the least-squares line through the points from `first` on.
double intercept(const std::vector<double>& x, const std::vector<double>& y, std::size_t first) {
  const auto n = static_cast<double>(x.size() - first);
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = first; i < x.size(); ++i) {
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return (sy - slope * sx) / n;
}

}  // namespace

std::string_view name_of(FilterMethod method) {
  switch (method) {
    case FilterMethod::none: return "none";
    case FilterMethod::butterworth: return "butterworth";
    case FilterMethod::savitzky_golay: return "savitzky-golay";
    case FilterMethod::moving_average: return "moving-average";
    case FilterMethod::median: return "median";
  }
  return "none";
}

void FilterOptions::declare(ParameterSet& p) {
  p.group("filter", "Smoothing");
  p.choice("filter", method,
           {{FilterMethod::none, "none", "leave the trajectories as they are"},
            {FilterMethod::butterworth, "butterworth", "low-pass without delay"},
            {FilterMethod::savitzky_golay, "savitzky-golay", "local polynomials; keeps peaks"},
            {FilterMethod::moving_average, "moving-average", "mean over a window"},
            {FilterMethod::median, "median", "median over a window; removes single outliers"}},
           "how trajectories are smoothed; never across gaps that were not filled");
  p.number("cutoff", cutoff_hz,
           {.unit = "Hz",
            .min = 0.0,
            .max = 1e5,
            .help = "cut-off of butterworth; 0 for the one that residual analysis suggests"});
  p.number("filter-order", order,
           {.min = 1, .max = 12, .help = "order of one of butterworth's two passes"});
  p.number("window", window,
           {.unit = "frames", .min = 3, .max = 10001, .help = "window of the others, odd"});
  p.number("degree", degree,
           {.min = 0, .max = 9, .help = "degree of savitzky-golay's polynomials"});
}

void FilterOptions::validate() const {
  validate_options(*this);
  const std::vector<std::string> changed =
      changed_parameters(*this, FilterOptions{.method = method});
  if (method == FilterMethod::none) {
    refuse_idle(changed, {"cutoff", "filter-order", "window", "degree"}, "nothing is smoothed",
                "Add --filter with a method, or leave it out");
  } else if (method == FilterMethod::butterworth) {
    refuse_idle(changed, {"window", "degree"}, "butterworth has a cut-off instead",
                "Use --cutoff, or leave it out");
  } else {
    refuse_idle(changed, {"cutoff", "filter-order"}, "only butterworth has a cut-off and an order",
                "Use --window, or leave it out");
    if (method != FilterMethod::savitzky_golay) {
      refuse_idle(changed, {"degree"}, "only savitzky-golay has a degree", "Leave it out");
    }
  }
  if (window % 2 == 0) {
    throw UsageError({.what = "the filter's window of " + std::to_string(window) + " is even",
                      .remedy = "Give an odd number of frames"});
  }
  if (method == FilterMethod::savitzky_golay && degree >= window) {
    throw UsageError({.what = "savitzky-golay needs a window above the degree",
                      .remedy = "Widen --window or lower --degree"});
  }
}

void filter_series(std::span<double> values, double rate_hz, const FilterOptions& options) {
  switch (options.method) {
    case FilterMethod::none: return;
    case FilterMethod::butterworth:
      filter::filter_both_ways(
          filter::butterworth_sections(options.order, options.cutoff_hz, rate_hz), options.order,
          values);
      return;
    case FilterMethod::savitzky_golay: {
      const int longest = static_cast<int>(std::min<std::size_t>(values.size(), 1U << 20U));
      const int window = std::min(options.window, longest - 1 + longest % 2);
      if (window > options.degree) filter::savitzky_golay(values, window, options.degree);
      return;
    }
    case FilterMethod::moving_average: filter::moving_average(values, options.window); return;
    case FilterMethod::median: filter::moving_median(values, options.window); return;
  }
}

double suggest_cutoff(std::span<const std::vector<double>> runs, double rate_hz, int order) {
  constexpr std::size_t least_frames = 30;  // in a run that can tell noise from motion
  const double highest = highest_share * rate_hz;
  std::vector<std::vector<double>> usable;
  for (const std::vector<double>& run : runs) {
    if (run.size() >= least_frames) usable.push_back(run);
  }
  if (usable.empty() || highest <= least_cutoff_hz) return highest;
  constexpr std::size_t steps = 60;
  std::vector<double> cutoffs;
  std::vector<double> residuals;
  for (std::size_t k = 0; k < steps; ++k) {
    cutoffs.push_back(least_cutoff_hz + (highest - least_cutoff_hz) * static_cast<double>(k) /
                                            static_cast<double>(steps - 1));
    residuals.push_back(residual(usable, rate_hz, order, cutoffs.back()));
  }
  // The upper 40 % of the frequencies hold noise alone in any recording worth smoothing.
  const double accepted = intercept(cutoffs, residuals, steps * 6 / 10);
  if (!(accepted > 0.0)) return highest;
  for (std::size_t k = 0; k < steps; ++k) {
    if (residuals[k] > accepted) continue;
    if (k == 0) return cutoffs[0];
    const double u = (residuals[k - 1] - accepted) / (residuals[k - 1] - residuals[k]);
    return cutoffs[k - 1] + u * (cutoffs[k] - cutoffs[k - 1]);
  }
  return highest;
}

FilterResult filter_take(const MarkerSequence& take, const FilterOptions& options,
                         const RunContext& ctx) {
  options.validate();
  const bool low_pass = options.method == FilterMethod::butterworth;
  if (low_pass && !(take.rate_hz > 0.0)) {
    throw UsageError({.what = "the take has no frame rate, so that no cut-off can be set",
                      .remedy = "Use --filter savitzky-golay"});
  }
  if (low_pass && options.cutoff_hz >= 0.5 * take.rate_hz) {
    throw UsageError({.what = "a cut-off of " + format_number(options.cutoff_hz) +
                              " Hz is not below half of the take's rate of " +
                              format_number(take.rate_hz) + " Hz",
                      .remedy = "Lower --cutoff, or give 0 to have it suggested"});
  }
  const bool windowed = options.method != FilterMethod::none && !low_pass;
  if (windowed && static_cast<std::size_t>(options.window) > take.frame_count()) {
    throw UsageError({.what = "a window of " +
                              count_of(static_cast<std::size_t>(options.window), "frame") +
                              " is longer than the take of " + std::to_string(take.frame_count()),
                      .remedy = take.frame_count() < shortest_run
                                    ? "Leave --filter out: there is nothing to smooth"
                                    : "Give a shorter --window"});
  }
  FilterResult result;
  result.take = take;
  std::vector<MarkerTally> tallies(take.marker_count());
  if (options.method != FilterMethod::none) {
    parallel_for(ctx, take.marker_count(), 1, [&](std::size_t m) {
      if (take.markers()[m].kind <= MarkerKind::virtual_point) {
        tallies[m] = filter_marker(result.take, m, options);
      }
    });
  }
  double squares = 0.0;
  std::size_t samples = 0;
  for (const MarkerTally& t : tallies) {
    result.cutoffs_hz.push_back(t.cutoff_hz);
    result.runs += t.runs;
    result.short_runs += t.short_runs;
    squares += t.squares;
    samples += t.samples;
  }
  if (samples > 0) result.rms_change_mm = std::sqrt(squares / static_cast<double>(samples));
  warn_of_lost_motion(take, tallies, result, ctx);
  if (result.short_runs > 0) {
    result.warnings.push_back(count_of(result.short_runs, "run") +
                              " of one or two samples between gaps were not smoothed.");
    ctx.warn(result.warnings.back());
  }
  return result;
}

}  // namespace kinemesh
