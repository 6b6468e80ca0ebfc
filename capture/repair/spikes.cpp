// find_spikes() of repair.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/repair.h"
#include "capture/repair/local_motion.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

using repair::LocalMotion;
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

/// Frames that a spike may last.
std::ptrdiff_t longest_spike(double rate_hz, const RepairOptions& options) {
  return std::max<std::ptrdiff_t>(
      1, static_cast<std::ptrdiff_t>(std::floor(options.spike_length_s * rate_hz)));
}

/// Where an unbroken run of samples ends: at a gap, or where the take begins or ends.
struct RunEnd {
  std::ptrdiff_t last = 0;    ///< the run's last sample
  std::ptrdiff_t inward = 0;  ///< ±1: from there into the run
};

/// A marker that leaves its path just before it is lost, or comes back beside it: there is no path
/// on the other side to compare with, so the samples must be off both from where the path leads and
/// from where the neighbours go. The tolerance grows with the way that is extrapolated: by `usual`
/// (the robust bend, times the ratio) a frame.
double spike_at_end(const Path& path, const LocalMotion& motion, std::size_t marker,
                    const RunEnd& end, std::ptrdiff_t length, double least, double usual) {
  const std::ptrdiff_t good = end.last + end.inward * length;
  for (std::ptrdiff_t k = 0; k <= 4; ++k) {
    if (!path.has(good + end.inward * k)) return 0.0;
  }
  const auto sample = [&](std::ptrdiff_t n) { return path[good + end.inward * n]; };
  const Eigen::Vector3d pace = 0.5 * (sample(0) - sample(2));
  double most = 0.0;
  for (std::ptrdiff_t n = 1; n <= length; ++n) {
    const std::ptrdiff_t f = good - end.inward * n;
    const double limit = std::max(2.0 * least, static_cast<double>(n) * usual);
    const double ahead = (path[f] - sample(0) - static_cast<double>(n) * pace).norm();
    if (ahead < limit) return 0.0;
    const Eigen::Vector3d carried = motion.carried(
        marker, sample(0), static_cast<std::size_t>(good), static_cast<std::size_t>(f));
    const double apart = std::min(ahead, (path[f] - carried).norm());
    if (apart < limit) return 0.0;
    most = std::max(most, apart);
  }
  // Before it left, the path was smooth.
  for (std::ptrdiff_t n = 0; n < 3; ++n) {
    constexpr double smooth = 0.2;
    const double bend = (sample(n + 1) - 0.5 * (sample(n) + sample(n + 2))).norm();
    if (bend >= smooth * most) return 0.0;
  }
  return most;
}

/// Spikes at both ends of every run of samples.
void add_end_spikes(const Path& path, const LocalMotion& motion, std::size_t marker,
                    std::ptrdiff_t longest, const RepairOptions& options, std::vector<Spike>& out) {
  const std::vector<double> bends = accelerations(path);
  const double least =
      std::max(options.spike_mm, options.spike_ratio * robust_sd(bends, 0, bends.size(), {}));
  const auto count = static_cast<std::ptrdiff_t>(path.seen.size());
  for (std::ptrdiff_t f = 0; f < count; ++f) {
    for (const std::ptrdiff_t inward : {std::ptrdiff_t{1}, std::ptrdiff_t{-1}}) {
      if (!path.has(f) || path.has(f - inward)) continue;
      constexpr std::ptrdiff_t around = 15;
      const auto begin = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, f - around));
      const auto end = static_cast<std::size_t>(std::min(count, f + around));
      for (std::ptrdiff_t length = 1; length <= longest; ++length) {
        const std::ptrdiff_t other = f + inward * length;
        const FrameRange frames{static_cast<std::size_t>(inward > 0 ? f : other + 1),
                                static_cast<std::size_t>(inward > 0 ? other : f + 1)};
        const FrameRange bent{frames.begin > 0 ? frames.begin - 1 : 0, frames.end + 1};
        const double usual = options.spike_ratio * robust_sd(bends, begin, end, bent);
        const double size = spike_at_end(path, motion, marker, {f, inward}, length, least, usual);
        if (size <= 0.0) continue;
        out.push_back({marker, frames, size});
        break;
      }
    }
  }
}

std::vector<Spike> spikes_of(const Path& path, std::size_t marker, double rate_hz,
                             const RepairOptions& options) {
  std::vector<Spike> out;
  const std::vector<double> bends = accelerations(path);
  const double own = robust_sd(bends, 0, bends.size(), {});
  const double least = std::max(options.spike_mm, options.spike_ratio * own);
  const std::ptrdiff_t longest = longest_spike(rate_hz, options);
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
  std::vector<std::size_t> columns;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind == MarkerKind::marker) columns.push_back(m);
  }
  const LocalMotion motion = LocalMotion::of(take, columns);
  std::vector<std::vector<Spike>> found(columns.size());
  parallel_for(ctx, columns.size(), 4, [&](std::size_t k) {
    const Path path = path_of(take, columns[k]);
    found[k] = spikes_of(path, k, take.rate_hz, options);
    add_end_spikes(path, motion, k, longest_spike(take.rate_hz, options), options, found[k]);
    for (Spike& spike : found[k]) spike.marker = columns[k];
  });
  std::vector<Spike> all;
  for (const auto& of_marker : found) all.insert(all.end(), of_marker.begin(), of_marker.end());
  return all;
}

}  // namespace kinemesh
