#include "capture/evaluate_fill.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>

#include "capture/fill/filler.h"
#include "capture/repair.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using fill::GapAt;
using fill::Trajectories;

constexpr std::array all_methods{FillMethod::automatic, FillMethod::linear,  FillMethod::cubic,
                                 FillMethod::quintic,   FillMethod::pattern, FillMethod::rigid,
                                 FillMethod::pca};

std::size_t below(std::mt19937_64& random, std::size_t bound) {
  return static_cast<std::size_t>(random() % bound);  // the bias is below 1e-12 for such bounds
}

/// Where a gap may begin, per marker: measured throughout and on either side.
std::vector<std::vector<std::size_t>> possible_starts(const Trajectories& take,
                                                      std::size_t length) {
  std::vector<std::vector<std::size_t>> out(take.markers());
  for (std::size_t m = 0; m < take.markers(); ++m) {
    std::size_t run = 0;
    for (std::size_t f = 0; f < take.frames(); ++f) {
      run = take.measured(m, f) ? run + 1 : 0;
      if (run >= length + 2) out[m].push_back(f - length);
    }
  }
  return out;
}

std::vector<GapAt> draw_gaps(const std::vector<std::vector<std::size_t>>& starts,
                             std::size_t markers, std::size_t length, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::size_t> order;
  for (std::size_t m = 0; m < starts.size(); ++m) {
    if (!starts[m].empty()) order.push_back(m);
  }
  std::vector<GapAt> gaps;
  for (std::size_t k = 0; k < markers; ++k) {
    std::swap(order[k], order[k + below(random, order.size() - k)]);
    const std::size_t m = order[k];
    const std::size_t begin = starts[m][below(random, starts[m].size())];
    gaps.push_back({m, {begin, begin + length}});
  }
  return gaps;
}

MarkerSequence with_noise(const MarkerSequence& take, double sd, uint64_t seed) {
  MarkerSequence noisy = take;
  std::mt19937_64 random(seed ^ 0x6e6f697365ULL);
  std::normal_distribution<double> noise(0.0, sd);
  for (float& value : noisy.positions()) value += static_cast<float>(noise(random));
  return noisy;
}

/// What somebody filled is no truth. Returns how many samples it forgets.
std::size_t forget_filled(MarkerSequence& take) {
  std::size_t forgotten = 0;
  for (uint8_t& flags : take.flags()) {
    if ((flags & SampleFlag::filled) == 0) continue;
    flags = 0;
    ++forgotten;
  }
  return forgotten;
}

/// What one method did in one trial.
struct TrialScore {
  std::vector<double> errors;  // mm, one per gap
  std::size_t not_filled = 0;
  std::size_t samples = 0, within = 0;
  double band_sum = 0.0;
  double seconds = 0.0;
};

/// `truth_noise`: variance of the noise in what stands for the truth, mm² per coordinate.
void add(TrialScore& score, const MarkerSequence& truth, double truth_noise, const GapAt& gap,
         const fill::Estimate& estimate) {
  double squares = 0.0;
  for (std::size_t i = 0; i < gap.frames.size(); ++i) {
    const Eigen::Vector3d p = truth.position(gap.frames.begin + i, gap.marker).cast<double>();
    const double error = (estimate.positions[i] - p).norm();
    squares += error * error;
    if (estimate.sd.empty()) continue;
    const double radius = fill_band_90 * std::sqrt(estimate.sd[i] * estimate.sd[i] + truth_noise);
    ++score.samples;
    score.within += error <= radius ? 1 : 0;
    score.band_sum += radius;
  }
  score.errors.push_back(std::sqrt(squares / static_cast<double>(gap.frames.size())));
}

TrialScore run_trial(const MarkerSequence& truth, const Trajectories& gapped,
                     const std::vector<GapAt>& gaps, FillMethod method, FillEffort effort,
                     bool clean_truth) {
  const auto begin = std::chrono::steady_clock::now();
  GapFillOptions options{.method = method, .effort = effort, .fill_rest = false};
  options.max_gap_s = std::numeric_limits<int>::max() / std::max(1.0, gapped.rate_hz());
  const fill::Filler filler(truth.markers(), gapped, options);
  TrialScore score;
  for (const GapAt& gap : gaps) {
    const std::optional<fill::Estimate> estimate = filler.estimate(gap);
    if (estimate) {
      const double noise = clean_truth ? 0.0 : fill::noise_variance(gapped, gap.marker);
      add(score, truth, noise, gap, *estimate);
    } else {
      ++score.not_filled;
    }
  }
  score.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return score;
}

double quantile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (at - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

FillScore summarise(FillMethod method, const std::vector<TrialScore>& trials) {
  FillScore out;
  out.method = method;
  std::vector<double> errors;
  std::size_t samples = 0;
  std::size_t within = 0;
  double band = 0.0;
  double seconds = 0.0;
  for (const TrialScore& t : trials) {
    errors.insert(errors.end(), t.errors.begin(), t.errors.end());
    out.not_filled += t.not_filled;
    samples += t.samples;
    within += t.within;
    band += t.band_sum;
    seconds += t.seconds;
  }
  std::ranges::sort(errors);
  out.gaps = errors.size();
  out.median_mm = quantile(errors, 0.5);
  out.percentile_90_mm = quantile(errors, 0.9);
  out.maximum_mm = quantile(errors, 1.0);
  const auto n = static_cast<double>(samples);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  out.within_band_percent = samples > 0 ? 100.0 * static_cast<double>(within) / n : unknown;
  out.band_width_mm = samples > 0 ? band / n : unknown;
  out.ms_per_gap = 1e3 * seconds / static_cast<double>(out.gaps + out.not_filled);
  return out;
}

FillMethod method_named(const std::string& word) {
  for (const FillMethod method : all_methods) {
    if (name_of(method) == lower(word)) return method;
  }
  std::vector<std::string> words;
  for (const FillMethod method : all_methods) words.emplace_back(name_of(method));
  throw UsageError(
      {.what = "--methods must be of " + join(words, ", ", " and ") + ", not \"" + word + "\""});
}

}  // namespace

void EvaluateFillOptions::declare(ParameterSet& p) {
  p.group("evaluation", "Evaluation of gap filling");
  p.number("markers", markers,
           {.min = 1, .max = 10000, .help = "markers that get one gap each in every trial"});
  p.number("gap", gap_s, {.unit = "s", .min = 0.001, .max = 600, .help = "length of the gaps"});
  p.number("trials", trials, {.min = 1, .max = 100000, .help = "trials"});
  p.number("noise", noise_mm,
           {.unit = "mm",
            .min = 0,
            .max = 100,
            .help = "noise added to every coordinate; errors are measured without it"});
  p.flag("repair", repair, "take out spikes and put exchanged labels right first, as process does");
  p.choice("effort", effort,
           {{FillEffort::automatic, "auto", "as the take is filled by process"},
            {FillEffort::full, "full", "as for a take with few gaps"},
            {FillEffort::fast, "fast", "as for a take with many gaps"}},
           "how long auto may take over a gap");
  p.list("methods", methods, {.metavar = "METHOD", .help = "methods to compare"});
}

void EvaluateFillOptions::validate() const {
  validate_options(*this);
  for (const std::string& word : methods) method_named(word);
}

EvaluateFillResult evaluate_fill(const MarkerSequence& given, const EvaluateFillOptions& options,
                                 const RunContext& ctx) {
  options.validate();
  EvaluateFillResult result;
  MarkerSequence recorded = given;
  if (const std::size_t filled = forget_filled(recorded); filled > 0) {
    result.warnings.push_back(count_of(filled, "sample was", "samples were") +
                              " filled by somebody and stand for gaps here, not for the truth.");
    ctx.warn(result.warnings.back());
  }
  MarkerSequence mended;
  if (options.repair) {
    RepairResult repaired = repair_take(recorded, {}, ctx.part(0.0, 0.02, "repair"));
    mended = std::move(repaired.take);
    result.repaired = std::move(repaired.done);
  }
  const MarkerSequence& take = options.repair ? mended : recorded;
  result.gap_frames =
      static_cast<std::size_t>(std::max(1.0, std::round(options.gap_s * take.rate_hz)));
  const Trajectories whole(options.noise_mm > 0.0 ? with_noise(take, options.noise_mm, ctx.seed())
                                                  : take);
  const auto starts = possible_starts(whole, result.gap_frames);
  result.candidates = static_cast<std::size_t>(
      std::ranges::count_if(starts, [](const auto& s) { return !s.empty(); }));
  const auto markers = static_cast<std::size_t>(options.markers);
  if (result.candidates < markers) {
    const bool none = result.candidates == 0;
    throw NoResultError(
        {.what = (none ? "No marker is"
                       : "Only " + count_of(result.candidates, "marker is", "markers are")) +
                 " measured for longer than a gap of " + format_number(options.gap_s) + " s",
         .file = take.origin.path,
         .remedy = take.frame_count() < 4 ? "Give a longer take"
                   : none                 ? "Give a shorter --gap or a longer take"
                          : "Give fewer markers with --markers or a shorter --gap"});
  }
  const auto trials = static_cast<std::size_t>(options.trials);
  for (std::size_t k = 0; k < options.methods.size(); ++k) {
    const FillMethod method = method_named(options.methods[k]);
    std::vector<TrialScore> scores(trials);
    const double count = static_cast<double>(options.methods.size());
    const RunContext part = ctx.part(static_cast<double>(k) / count,
                                     static_cast<double>(k + 1) / count, options.methods[k]);
    parallel_for(part, trials, 1, [&](std::size_t t) {
      const auto gaps = draw_gaps(starts, markers, result.gap_frames, ctx.seed() * 1000003ULL + t);
      Trajectories gapped = whole;
      for (const GapAt& gap : gaps) gapped.forget(gap.marker, gap.frames);
      scores[t] = run_trial(take, gapped, gaps, method, options.effort, options.noise_mm > 0.0);
    });
    part.progress(1.0);
    result.scores.push_back(summarise(method, scores));
    if (result.scores.back().not_filled > 0) {
      result.warnings.push_back(std::string(name_of(method)) + " could not fill " +
                                count_of(result.scores.back().not_filled, "gap") +
                                "; its figures are of the others.");
      ctx.warn(result.warnings.back());
    }
  }
  return result;
}

}  // namespace kinemesh
