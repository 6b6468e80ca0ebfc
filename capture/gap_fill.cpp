#include "capture/gap_fill.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "capture/fill/filler.h"
#include "capture/idle_options.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using fill::Estimate;
using fill::GapAt;
using fill::Trajectories;

void write(const GapAt& gap, const Estimate& estimate, MarkerSequence& take) {
  for (std::size_t i = 0; i < gap.frames.size(); ++i) {
    const std::size_t frame = gap.frames.begin + i;
    const std::size_t s = take.sample(frame, gap.marker);
    take.position(frame, gap.marker) = estimate.positions[i].cast<float>();
    take.flags()[s] = SampleFlag::valid | SampleFlag::filled;
    take.residuals()[s] = 0.0F;
    take.camera_masks()[s] = 0;
    take.uncertainty()[s] = static_cast<float>(estimate.sd[i]);
  }
}

void warn(GapFillResult& result, const RunContext& ctx, std::string text) {
  ctx.warn(text);
  result.warnings.push_back(std::move(text));
}

/// Where nothing was measured, nothing can be filled; what was measured once is filled from afar.
void warn_of_lost(const MarkerSequence& take, GapFillResult& result, const RunContext& ctx) {
  constexpr std::size_t most = 8;  // names in the message
  std::vector<std::string> labels;
  for (const std::size_t m : result.never_valid) {
    labels.push_back(labels.size() == most ? "…" : take.markers()[m].label);
    if (labels.size() > most) break;
  }
  if (labels.empty()) return;
  warn(result, ctx,
       count_of(result.never_valid.size(), "marker was", "markers were") +
           " not measured in any frame and cannot be filled (" + join(labels, ", ") +
           "): there will be nothing in their place. If the region matters, repeat the take.");
}

/// A few samples do not show how a marker moves.
void warn_of_scarce(const MarkerSequence& take, const Trajectories& trajectories,
                    GapFillResult& result, const RunContext& ctx) {
  constexpr std::size_t most = 8;  // names in the message
  std::vector<std::string> labels;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const std::size_t count = trajectories.measured_count(m);
    if (count > 0 && 10 * count < take.frame_count()) labels.push_back(take.markers()[m].label);
  }
  if (labels.empty()) return;
  const std::string who = count_of(labels.size(), "marker was", "markers were");
  if (labels.size() > most) {
    labels.resize(most);
    labels.emplace_back("…");
  }
  warn(result, ctx,
       who + " measured in less than 10 % of the frames (" + join(labels, ", ") +
           "): what is filled there follows their neighbours and may be off by centimetres where "
           "the face does what it does not in those frames. If the region matters, repeat the "
           "take.");
}

/// A person who limits the length of gaps expects longer ones to stay open.
void warn_of_idle_limit(const GapFillOptions& options, GapFillResult& result,
                        const RunContext& ctx) {
  if (options.max_gap_s == GapFillOptions{}.max_gap_s) return;
  const bool spline = options.method == FillMethod::linear || options.method == FillMethod::cubic ||
                      options.method == FillMethod::quintic;
  if (spline && !options.fill_rest) return;
  warn(result, ctx,
       "Gaps longer than --max-gap are filled, too, by " +
           std::string(name_of(spline ? FillMethod::automatic : options.method)) +
           ": the limit holds for linear, cubic and quintic, and leaves longer gaps open only with "
           "--no-fill-rest.");
}

}  // namespace

std::string_view name_of(FillMethod method) {
  switch (method) {
    case FillMethod::automatic: return "auto";
    case FillMethod::linear: return "linear";
    case FillMethod::cubic: return "cubic";
    case FillMethod::quintic: return "quintic";
    case FillMethod::pattern: return "pattern";
    case FillMethod::rigid: return "rigid";
    case FillMethod::pca: return "pca";
    case FillMethod::hold: return "hold";
  }
  return "auto";
}

void GapFillOptions::declare(ParameterSet& p) {
  p.group("gaps", "Gap filling");
  p.choice("fill", method,
           {{FillMethod::automatic, "auto", "the most accurate: other markers and time together"},
            {FillMethod::linear, "linear", "straight line across the gap"},
            {FillMethod::cubic, "cubic", "cubic spline"},
            {FillMethod::quintic, "quintic", "quintic spline"},
            {FillMethod::pattern, "pattern", "the motion of a donor marker"},
            {FillMethod::rigid, "rigid", "three or more companions as a rigid body"},
            {FillMethod::pca, "pca", "correlations between markers"}},
           "how gaps are filled");
  p.choice("effort", effort,
           {{FillEffort::automatic, "auto", "full for up to 100 gaps, fast for more"},
            {FillEffort::full, "full", "some 10 ms a gap"},
            {FillEffort::fast, "fast", "some 1 ms a gap"}},
           "how long auto may take over a gap");
  p.number("max-gap", max_gap_s,
           {.unit = "s",
            .min = 0,
            .max = 3600,
            .help = "longest gap that linear, cubic and quintic fill"});
  p.text("donor", donor,
         {.metavar = "MARKER",
          .help = "marker whose motion pattern copies; by default the nearest seen throughout"});
  p.list("companion", companions,
         {.metavar = "MARKER",
          .help = "markers that rigid takes as one body; by default the six nearest"});
  p.flag("fill-rest", fill_rest, "fill by auto what the chosen method cannot fill");
}

void GapFillOptions::validate() const {
  validate_options(*this);
  const std::vector<std::string> changed = changed_parameters(*this);
  const std::string by = "gaps are filled by " + std::string(name_of(method));
  if (method != FillMethod::pattern) {
    refuse_idle(changed, {"donor"}, by, "Add --fill pattern, or leave it out");
  }
  if (method != FillMethod::rigid) {
    refuse_idle(changed, {"companion"}, by, "Add --fill rigid, or leave it out");
  }
  std::vector<std::string> distinct = companions;
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  if (!companions.empty() && distinct.size() < 3) {
    throw UsageError({.what = "a rigid body needs three companions at least, and " +
                              count_of(distinct.size(), "marker is", "markers are") + " named",
                      .remedy = "Name more with --companion, or none to have the six nearest"});
  }
}

GapFillResult fill_gaps(const MarkerSequence& take, const GapFillOptions& options,
                        const RunContext& ctx) {
  options.validate();
  const Trajectories trajectories(take);
  const fill::Filler filler(take.markers(), trajectories, options);
  GapFillResult result;
  result.take = take;
  std::vector<GapAt> gaps;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (trajectories.measured_count(m) == 0) {
      result.never_valid.push_back(m);
      continue;
    }
    for (const FrameRange frames : trajectories.gaps(m)) gaps.push_back({m, frames});
  }
  warn_of_lost(take, result, ctx);
  warn_of_scarce(take, trajectories, result, ctx);
  warn_of_idle_limit(options, result, ctx);
  if (gaps.empty()) return result;
  result.take.add_uncertainty();

  std::vector<fill::Filled> filled(gaps.size());
  std::atomic<std::size_t> done{0};
  parallel_for(ctx, gaps.size(), 1, [&](std::size_t i) {
    filled[i] = filler.fill(gaps[i]);
    ctx.progress(static_cast<double>(++done) / static_cast<double>(gaps.size()));
  });
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (!filled[i].estimate) continue;
    const Estimate& estimate = *filled[i].estimate;
    write(gaps[i], estimate, result.take);
    const double sum = std::accumulate(estimate.sd.begin(), estimate.sd.end(), 0.0);
    result.fills.push_back({gaps[i].marker, gaps[i].frames, filled[i].method,
                            sum / static_cast<double>(estimate.sd.size()),
                            std::ranges::max(estimate.sd)});
  }
  return result;
}

}  // namespace kinemesh
