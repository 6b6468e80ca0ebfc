#include "capture/fill/scarce.h"

#include <algorithm>
#include <cmath>

#include "capture/fill/common_frame.h"

namespace kinemesh::fill {
namespace {

/// Measured frames of the marker, evenly thinned to `most`.
std::vector<std::size_t> known_frames(const Trajectories& take, std::size_t marker,
                                      std::size_t most) {
  std::vector<std::size_t> all;
  for (std::size_t f = 0; f < take.frames(); ++f) {
    if (take.measured(marker, f)) all.push_back(f);
  }
  if (all.size() <= most) return all;
  std::vector<std::size_t> thinned;
  for (std::size_t k = 0; k < most; ++k) {
    thinned.push_back(all[k * (all.size() - 1) / (most - 1)]);
  }
  return thinned;
}

/// Other markers by their distance in the frames where this one is measured.
std::vector<std::size_t> nearest_there(const Trajectories& take, const Trajectories& rough,
                                       std::size_t marker, const std::vector<std::size_t>& frames) {
  std::vector<std::pair<double, std::size_t>> others;
  for (std::size_t m = 0; m < take.markers(); ++m) {
    if (m == marker || take.measured_count(m) == 0 || is_scarce(take, m)) continue;
    double distance = 0.0;
    for (const std::size_t f : frames) distance += (rough.at(m, f) - rough.at(marker, f)).norm();
    others.emplace_back(distance, m);
  }
  std::ranges::sort(others);
  std::vector<std::size_t> out;
  for (const auto& [distance, m] : others) out.push_back(m);
  return out;
}

}  // namespace

bool is_scarce(const Trajectories& take, std::size_t marker) {
  return 4 * take.measured_count(marker) < take.frames();
}

void raise_sd_of_scarce(const Trajectories& take, const Trajectories& rough, const GapAt& gap,
                        Estimate& estimate) {
  constexpr std::size_t most_rows = 200;
  constexpr std::size_t most_markers = 150;  // of the common frame
  constexpr std::size_t most_neighbours = 8;
  constexpr double unknown_mm = 10.0;
  std::vector<std::size_t> frames = known_frames(take, gap.marker, most_rows);
  const std::size_t rows = frames.size();
  std::vector<std::size_t> others = nearest_there(take, rough, gap.marker, frames);
  if (others.size() < 4) {
    for (double& sd : estimate.sd) sd = std::max(sd, unknown_mm);
    return;
  }
  others.resize(std::min(others.size(), most_markers));
  for (std::size_t f = gap.frames.begin; f < gap.frames.end; ++f) frames.push_back(f);
  const CommonFrame common(rough, others, frames, rows, 2);
  const std::size_t neighbours = std::min(others.size(), most_neighbours);
  std::vector<Eigen::Vector3d> rest;
  for (std::size_t k = 0; k < neighbours; ++k) rest.push_back(common.mean(k, rows));
  const auto motion = [&](std::size_t i) {
    double most = 0.0;
    for (std::size_t k = 0; k < neighbours; ++k) {
      most = std::max(most, (common.inside(i, k) - rest[k]).squaredNorm() / 3.0);
    }
    return most;
  };
  double known = 0.0;
  for (std::size_t i = 0; i < rows; ++i) known = std::max(known, motion(i));
  for (std::size_t i = 0; i < estimate.sd.size(); ++i) {
    const double unknown = std::max(0.0, motion(rows + i) - known);
    estimate.sd[i] = std::max(estimate.sd[i], std::sqrt(unknown));
  }
}

}  // namespace kinemesh::fill
