// find_spikes() of repair.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/repair.h"
#include "capture/repair/local_motion.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

using repair::median_of;

/// One marker's measured samples.
struct Path {
  std::vector<Eigen::Vector3d> at;
  std::vector<uint8_t> seen;
  bool has(std::ptrdiff_t f) const {
    return f >= 0 && f < static_cast<std::ptrdiff_t>(seen.size()) &&
           seen[static_cast<std::size_t>(f)] != 0;
  }
  const Eigen::Vector3d& operator[](std::ptrdiff_t f) const {
    return at[static_cast<std::size_t>(f)];
  }
};

Path path_of(const MarkerSequence& take, std::size_t m) {
  Path path;
  path.at.reserve(take.frame_count());
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    path.at.emplace_back(take.position(f, m).cast<double>());
    path.seen.push_back(repair::measured(take, f, m) ? 1 : 0);
  }
  return path;
}

/// Distance of each sample from the mean of those beside it; −1 where one of the three is missing.
std::vector<double> accelerations(const Path& path) {
  std::vector<double> out(path.at.size(), -1.0);
  for (std::size_t f = 1; f + 1 < path.at.size(); ++f) {
    if (path.seen[f - 1] == 0 || path.seen[f] == 0 || path.seen[f + 1] == 0) continue;
    out[f] = (path.at[f] - 0.5 * (path.at[f - 1] + path.at[f + 1])).norm();
  }
  return out;
}

double robust_sd(const std::vector<double>& values, std::size_t begin, std::size_t end,
                 FrameRange without) {
  std::vector<double> kept;
  for (std::size_t f = begin; f < end; ++f) {
    if (values[f] >= 0.0 && (f < without.begin || f >= without.end)) kept.push_back(values[f]);
  }
  constexpr double of_normal = 1.4826;
  return kept.empty() ? 0.0 : of_normal * median_of(kept);
}

/// Lagrange interpolation through four samples.
Eigen::Vector3d through(const Path& path, const std::array<std::ptrdiff_t, 4>& knots,
                        std::ptrdiff_t f) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < 4; ++j) {
      if (j == i) continue;
      weight *= static_cast<double>(f - knots[j]) / static_cast<double>(knots[i] - knots[j]);
    }
    sum += weight * path[knots[i]];
  }
  return sum;
}

/// The largest deviation when [f, f + length) is a spike; 0 when it is none.
double spike_at(const Path& path, std::ptrdiff_t f, std::ptrdiff_t length, double least) {
  const std::ptrdiff_t end = f + length;
  for (std::ptrdiff_t k = f - 3; k < end + 3; ++k) {
    if (!path.has(k)) return 0.0;
  }
  const std::array<std::ptrdiff_t, 4> around = {f - 2, f - 1, end, end + 1};
  double most = 0.0;
  for (std::ptrdiff_t k = f; k < end; ++k) {
    const double deviation = (path[k] - through(path, around, k)).norm();
    if (deviation < least) return 0.0;
    most = std::max(most, deviation);
  }
  // Without the spike the path must be smooth.
  const double before = (path[f - 1] - through(path, {f - 3, f - 2, end, end + 1}, f - 1)).norm();
  const double after = (path[end] - through(path, {f - 2, f - 1, end + 1, end + 2}, end)).norm();
  constexpr double smooth = 0.35;
  if (std::max(before, after) >= smooth * most) return 0.0;
  // And go on where it was: a marker that stays elsewhere is no spike.
  const Eigen::Vector3d pace = 0.5 * (path[f - 1] - path[f - 2] + path[end + 1] - path[end]) *
                               static_cast<double>(length + 1);
  return (path[end] - path[f - 1] - pace).norm() < most ? most : 0.0;
}

std::vector<Spike> spikes_of(const Path& path, std::size_t marker, double rate_hz,
                             const RepairOptions& options) {
  std::vector<Spike> out;
  const std::vector<double> bends = accelerations(path);
  const double own = robust_sd(bends, 0, bends.size(), {});
  const double least = std::max(options.spike_mm, options.spike_ratio * own);
  const auto longest = std::max<std::ptrdiff_t>(
      1, static_cast<std::ptrdiff_t>(std::floor(options.spike_length_s * rate_hz)));
  for (std::size_t f = 1; f + 1 < bends.size(); ++f) {
    if (bends[f] < 0.5 * least) continue;  // the first sample of a spike bends the path at least so
    for (std::ptrdiff_t length = 1; length <= longest; ++length) {
      const double deviation = spike_at(path, static_cast<std::ptrdiff_t>(f), length, least);
      if (deviation <= 0.0) continue;
      const FrameRange frames{f, f + static_cast<std::size_t>(length)};
      constexpr std::size_t around = 15;
      const std::size_t begin = f > around ? f - around : 0;
      const std::size_t end = std::min(bends.size(), frames.end + around);
      const double local = robust_sd(bends, begin, end, {f - 1, frames.end + 1});
      if (deviation < options.spike_ratio * local) continue;
      out.push_back({marker, frames, deviation});
      f = frames.end;
      break;
    }
  }
  return out;
}

}  // namespace

std::vector<Spike> find_spikes(const MarkerSequence& take, const RepairOptions& options,
                               const RunContext& ctx) {
  std::vector<std::vector<Spike>> found(take.marker_count());
  parallel_for(ctx, take.marker_count(), 4, [&](std::size_t m) {
    if (take.markers()[m].kind != MarkerKind::marker) return;
    found[m] = spikes_of(path_of(take, m), m, take.rate_hz, options);
  });
  std::vector<Spike> all;
  for (const auto& of_marker : found) all.insert(all.end(), of_marker.begin(), of_marker.end());
  return all;
}

}  // namespace kinemesh
