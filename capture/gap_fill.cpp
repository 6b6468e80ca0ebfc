#include "capture/gap_fill.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/fill/automatic.h"
#include "capture/fill/companions.h"
#include "capture/fill/left_out.h"
#include "capture/fill/spline.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using fill::Estimate;
using fill::GapAt;
using fill::Trajectories;

/// Indices of markers by label.
std::size_t marker_named(const MarkerSequence& take, const std::string& label,
                         const char* parameter) {
  const std::size_t m = take.find(label);
  if (m != MarkerSequence::npos) return m;
  std::vector<std::string> labels;
  for (const Marker& marker : take.markers()) labels.push_back(marker.label);
  const std::string near = nearest_word(label, labels);
  throw UsageError(
      {.what = "--" + std::string(parameter) + " names no marker of the take: \"" + label + "\"",
       .remedy = near.empty() ? "see the labels with \"kinemesh c3d info\""
                              : "did you mean \"" + near + "\"?"});
}

/// Options resolved against one take.
struct Plan {
  FillMethod method = FillMethod::automatic;
  std::size_t max_gap = 0;  // frames
  std::size_t donor = MarkerSequence::npos;
  std::vector<std::size_t> companions;
};

Plan resolve(const MarkerSequence& take, const GapFillOptions& options) {
  Plan plan;
  plan.method = options.method;
  plan.max_gap = static_cast<std::size_t>(std::floor(options.max_gap_s * take.rate_hz + 1e-6));
  if (!options.donor.empty()) plan.donor = marker_named(take, options.donor, "donor");
  for (const std::string& label : options.companions) {
    plan.companions.push_back(marker_named(take, label, "companion"));
  }
  return plan;
}

std::optional<Estimate> fill_by(const Plan& plan, const Trajectories& take, const GapAt& gap) {
  switch (plan.method) {
    case FillMethod::linear:
    case FillMethod::cubic:
    case FillMethod::quintic:
      if (gap.frames.size() > plan.max_gap) return std::nullopt;
      return fill_spline(take, gap,
                         plan.method == FillMethod::linear  ? 1
                         : plan.method == FillMethod::cubic ? 3
                                                            : 5);
    case FillMethod::pattern: {
      if (plan.donor != MarkerSequence::npos) return fill_pattern(take, gap, plan.donor);
      const auto near = seen_throughout(take, gap, take.nearest(gap.marker), 1);
      return near.empty() ? std::nullopt : fill_pattern(take, gap, near.front());
    }
    case FillMethod::rigid: {
      if (!plan.companions.empty()) return fill_rigid(take, gap, plan.companions);
      constexpr std::size_t companions = 6;
      return fill_rigid(take, gap,
                        seen_throughout(take, gap, take.nearest(gap.marker), companions));
    }
    default: return std::nullopt;
  }
}

struct Filled {
  std::optional<Estimate> estimate;
  FillMethod method = FillMethod::automatic;
};

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

GapFillResult fill_gaps(const MarkerSequence& take, const GapFillOptions& options,
                        const RunContext& ctx) {
  options.validate();
  const Plan plan = resolve(take, options);
  const Trajectories trajectories(take);
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
  for (const std::size_t m : result.never_valid) {
    warn(result, ctx,
         "Marker " + take.markers()[m].label + " is invalid in every frame and cannot be filled.");
  }
  if (gaps.empty()) return result;
  result.take.add_uncertainty();

  std::vector<Filled> filled(gaps.size());
  const fill::Automatic automatic(trajectories);
  const fill::Method chosen = [&](const GapAt& gap) { return fill_by(plan, trajectories, gap); };
  parallel_for(ctx, gaps.size(), 1, [&](std::size_t i) {
    filled[i] = {chosen(gaps[i]), plan.method};
    if (filled[i].estimate) {
      set_sd_from_left_out(trajectories, gaps[i], chosen, *filled[i].estimate);
    } else if (options.fill_rest || plan.method == FillMethod::automatic) {
      filled[i] = {automatic.fill(gaps[i]), FillMethod::automatic};
    }
  });
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (!filled[i].estimate) continue;
    const Estimate& estimate = *filled[i].estimate;
    write(gaps[i], estimate, result.take);
    const double sum = std::accumulate(estimate.sd.begin(), estimate.sd.end(), 0.0);
    result.fills.push_back({gaps[i].marker, gaps[i].frames, filled[i].method,
                            sum / static_cast<double>(estimate.sd.size())});
  }
  return result;
}

}  // namespace kinemesh
