#include "capture/fill/automatic.h"

#include "capture/fill/companions.h"
#include "capture/fill/left_out.h"

namespace kinemesh::fill {

Trajectories fill_roughly(const Trajectories& take) {
  constexpr std::size_t neighbours = 6;
  Trajectories rough = take;
  for (std::size_t m = 0; m < take.markers(); ++m) {
    if (take.measured_count(m) == 0) continue;
    const std::vector<FrameRange> gaps = take.gaps(m);
    const std::vector<std::size_t> nearest =
        gaps.empty() ? std::vector<std::size_t>{} : take.nearest(m);
    for (const FrameRange frames : gaps) {
      const GapAt gap{m, frames};
      const auto seen = seen_throughout(take, gap, nearest, neighbours);
      const Estimate estimate = bridge(take, gap, [&](std::size_t f) {
        Eigen::Vector3d moved = Eigen::Vector3d::Zero();
        for (const std::size_t d : seen) moved += take.at(d, f) / static_cast<double>(seen.size());
        return moved;
      });
      for (std::size_t i = 0; i < frames.size(); ++i) {
        rough.put(m, frames.begin + i, estimate.positions[i]);
      }
    }
  }
  return rough;
}

namespace {

struct Effort {
  TrainingOptions training;
  ProcessOptions process;
};

/// What a gap of this length is worth. Short gaps need little beside the samples next to them.
Effort effort_for(const AutomaticOptions& options, double gap_s) {
  Effort effort;
  if (!options.fast) return effort;
  constexpr double short_s = 0.16;
  const bool brief = gap_s <= short_s;
  effort.training.rows = brief ? 56 : 120;
  effort.training.donors = brief ? 10 : 16;
  effort.training.frame_rounds = 1;
  effort.training.guess.adapt = brief ? GuessAdapt::never : GuessAdapt::where_new;
  effort.process.noise_rows = brief ? 40 : 60;
  effort.process.noise_step = 10.0;
  effort.process.lengths = {0.25};
  if (brief) effort.process.times_s = {10.0 / 60.0};
  if (!brief) effort.process.widening = 1.1;  // 80 to 86 % in the band on AnimFace without it
  return effort;
}

}  // namespace

Automatic::Automatic(const Trajectories& take, const AutomaticOptions& options)
    : take_(take), options_(options), rough_(fill_roughly(take)), noise_(take.markers(), 0.0) {
  mirror_ = find_mirror(rough_);
  for (std::size_t m = 0; m < take.markers(); ++m) {
    if (take.measured_count(m) > 0 && take.measured_count(m) < take.frames()) {
      noise_[m] = noise_variance(take, m);
    }
  }
}

Estimate Automatic::fill(const GapAt& gap) const {
  constexpr std::size_t least_rows = 8;  // with fewer there is nothing to learn from
  if (take_.measured_count(gap.marker) >= least_rows) {
    const double rate = take_.rate_hz() > 0.0 ? take_.rate_hz() : 60.0;
    const Effort effort = effort_for(options_, static_cast<double>(gap.frames.size()) / rate);
    const TrainingSet set =
        make_training_set(take_, rough_, mirror_ ? &*mirror_ : nullptr, gap, effort.training);
    if (set.rows.size() >= least_rows) {
      return estimate_gap(set, take_.rate_hz(), noise_[gap.marker], effort.process);
    }
  }
  Estimate rough;
  for (std::size_t f = gap.frames.begin; f < gap.frames.end; ++f) {
    rough.positions.emplace_back(rough_.at(gap.marker, f));
  }
  set_sd_from_left_out(
      take_, gap, [this](const GapAt& at) { return fill_hold(take_, at); }, rough);
  return rough;
}

}  // namespace kinemesh::fill
