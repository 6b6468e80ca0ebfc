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

Automatic::Automatic(const Trajectories& take) : take_(take), rough_(fill_roughly(take)) {}

Estimate Automatic::fill(const GapAt& gap) const {
  constexpr std::size_t least_rows = 8;  // with fewer there is nothing to learn from
  if (take_.measured_count(gap.marker) >= least_rows) {
    const TrainingSet set = make_training_set(take_, rough_, gap, {});
    if (set.rows.size() >= least_rows) {
      return estimate_gap(set, take_.rate_hz(), noise_variance(take_, gap.marker));
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
