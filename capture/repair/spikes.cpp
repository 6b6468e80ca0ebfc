// find_spikes() of repair.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>

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
    path.seen.push_back(measured(take, f, m) ? 1 : 0);
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

/// Samples to interpolate through, the nearest first.
struct Knots {
  std::vector<std::ptrdiff_t> before, after;
};

/// Lagrange interpolation through samples.
Eigen::Vector3d through(const Path& path, std::initializer_list<std::ptrdiff_t> knots,
                        std::ptrdiff_t f) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::ptrdiff_t i : knots) {
    double weight = 1.0;
    for (const std::ptrdiff_t j : knots) {
      if (j != i) weight *= static_cast<double>(f - j) / static_cast<double>(i - j);
    }
    sum += weight * path[i];
  }
  return sum;
}

constexpr std::ptrdiff_t reach = 6;  // frames beside a spike in which samples are looked for

/// Up to three samples on either side of [f, end), without `skipped`.
Knots knots_around(const Path& path, std::ptrdiff_t f, std::ptrdiff_t end, std::ptrdiff_t skipped) {
  constexpr std::size_t most = 3;
  Knots knots;
  for (std::ptrdiff_t k = f - 1; k >= f - reach && knots.before.size() < most; --k) {
    if (k != skipped && path.has(k)) knots.before.push_back(k);
  }
  for (std::ptrdiff_t k = end; k < end + reach && knots.after.size() < most; ++k) {
    if (k != skipped && path.has(k)) knots.after.push_back(k);
  }
  return knots;
}

/// Where the samples around say that the marker was in frame f: a cubic, or a parabola where there
/// is one sample alone on one side. Nothing where there are too few.
std::optional<Eigen::Vector3d> expected(const Path& path, const Knots& at, std::ptrdiff_t f) {
  const auto& b = at.before;
  const auto& a = at.after;
  if (b.size() >= 2 && a.size() >= 2) return through(path, {b[1], b[0], a[0], a[1]}, f);
  if (b.size() == 1 && a.size() >= 3) return through(path, {b[0], a[0], a[1]}, f);
  if (a.size() == 1 && b.size() >= 3) return through(path, {b[1], b[0], a[0]}, f);
  return std::nullopt;
}

/// How far the samples beside the spike are from where those around them lead, without the spike.
double misfit(const Path& path, const Knots& at) {
  const auto off = [&](const std::vector<std::ptrdiff_t>& near,
                       const std::vector<std::ptrdiff_t>& far) {
    if (near.size() < 2) return 0.0;  // the neighbours are asked instead
    const Eigen::Vector3d there = near.size() > 2 && far.size() > 1
                                      ? through(path, {near[2], near[1], far[0], far[1]}, near[0])
                                  : far.size() > 1
                                      ? through(path, {near[1], far[0], far[1]}, near[0])
                                      : through(path, {near[2], near[1], far[0]}, near[0]);
    return (path[near[0]] - there).norm();
  };
  return std::max(off(at.before, at.after), off(at.after, at.before));
}

/// The path goes on where it was: a marker that stays elsewhere is no spike.
bool goes_on(const Path& path, const Knots& at, double most) {
  Eigen::Vector3d pace = Eigen::Vector3d::Zero();
  double sides = 0.0;
  for (const auto* side : {&at.before, &at.after}) {
    if (side->size() < 2) continue;
    const auto& k = *side;
    pace += (path[k[1]] - path[k[0]]) / static_cast<double>(k[1] - k[0]);
    sides += 1.0;
  }
  pace *= static_cast<double>(at.after[0] - at.before[0]) / sides;
  constexpr double near = 0.7;
  return (path[at.after[0]] - path[at.before[0]] - pace).norm() < near * most;
}

/// One marker, its neighbours, and the least deviation of a spike.
struct Suspect {
  const Path& path;
  const LocalMotion& motion;
  std::size_t marker = 0;
  double least = 0.0;
};

/// The neighbours agree that the marker cannot have been there, seen from either side.
bool neighbours_disagree(const Suspect& s, const Knots& at, std::ptrdiff_t f) {
  return std::ranges::all_of(std::array{at.before[0], at.after[0]}, [&](std::ptrdiff_t from) {
    const Eigen::Vector3d there = s.motion.carried(
        s.marker, s.path[from], static_cast<std::size_t>(from), static_cast<std::size_t>(f));
    return (s.path[f] - there).norm() >= s.least;
  });
}

/// A spike, and how well the path fits without it.
struct Finding {
  Spike spike;
  double roughness = 1.0;  ///< misfit of the samples beside it, in relation to its size
};

/// Is [f, f + length) a spike? `skipped`: a sample beside it that must be off as well, and is not
/// asked.
std::optional<Finding> spike_at(const Suspect& s, std::ptrdiff_t f, std::ptrdiff_t length,
                                std::ptrdiff_t skipped) {
  const std::ptrdiff_t end = f + length;
  const Knots at = knots_around(s.path, f, end, skipped);
  const auto off = [&](std::ptrdiff_t k) {
    const auto there = expected(s.path, at, k);
    return there ? (s.path[k] - *there).norm() : 0.0;
  };
  if (skipped >= 0 && off(skipped) < s.least) return std::nullopt;
  const bool alone = std::min(at.before.size(), at.after.size()) < 2;
  double most = 0.0;
  for (std::ptrdiff_t k = f; k < end; ++k) {
    const double deviation = s.path.has(k) ? off(k) : 0.0;
    if (deviation < s.least) return std::nullopt;
    if (alone && !neighbours_disagree(s, at, k)) return std::nullopt;
    most = std::max(most, deviation);
  }
  constexpr double smooth = 0.35;
  const double roughness = misfit(s.path, at) / most;
  if (roughness >= smooth || !goes_on(s.path, at, most)) return std::nullopt;
  const FrameRange frames{static_cast<std::size_t>(f), static_cast<std::size_t>(end)};
  return Finding{{s.marker, frames, most}, roughness};
}

/// The same; where a second spike close by spoils the look around, without one of its samples.
std::optional<Finding> spike_near_others(const Suspect& s, std::ptrdiff_t f,
                                         std::ptrdiff_t length) {
  std::optional<Finding> best = spike_at(s, f, length, -1);
  if (best) return best;
  const Knots at = knots_around(s.path, f, f + length, -1);
  for (const auto* side : {&at.before, &at.after}) {
    for (const std::ptrdiff_t other : *side) {
      const auto found = spike_at(s, f, length, other);
      if (found && (!best || found->roughness < best->roughness)) best = found;
    }
  }
  return best;
}

/// A first look: off the line between the samples before and after.
bool suspicious(const Suspect& s, std::ptrdiff_t f) {
  std::ptrdiff_t b = f - 1, a = f + 1;
  while (b >= f - reach && !s.path.has(b)) --b;
  while (a <= f + reach && !s.path.has(a)) ++a;
  if (b < f - reach || a > f + reach) return false;
  return (s.path[f] - through(s.path, {b, a}, f)).norm() >= 0.4 * s.least;
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

/// Spikes at both ends of every run of samples, as `recorded`.
void add_end_spikes(const Path& path, const std::vector<uint8_t>& recorded,
                    const LocalMotion& motion, std::size_t marker, std::ptrdiff_t longest,
                    const RepairOptions& options, std::vector<Spike>& out) {
  const std::vector<double> bends = accelerations(path);
  const double least =
      std::max(options.spike_mm, options.spike_ratio * robust_sd(bends, 0, bends.size(), {}));
  const auto count = static_cast<std::ptrdiff_t>(path.seen.size());
  for (std::ptrdiff_t f = 0; f < count; ++f) {
    for (const std::ptrdiff_t inward : {std::ptrdiff_t{1}, std::ptrdiff_t{-1}}) {
      const std::ptrdiff_t outside = f - inward;
      if (!path.has(f) ||
          (outside >= 0 && outside < count && recorded[static_cast<std::size_t>(outside)] != 0)) {
        continue;
      }
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

/// All that may be a spike between samples that show the path as it is; more than one at a place.
std::vector<Finding> spikes_between(const Suspect& s, const std::vector<double>& bends,
                                    std::ptrdiff_t longest, const RepairOptions& options) {
  std::vector<Finding> out;
  const auto count = static_cast<std::ptrdiff_t>(s.path.seen.size());
  for (std::ptrdiff_t f = 0; f < count; ++f) {
    if (!s.path.has(f) || !suspicious(s, f)) continue;
    for (std::ptrdiff_t length = 1; length <= longest && f + length < count; ++length) {
      Suspect longer = s;  // real motion has more room in more frames; noise has not
      longer.least = std::max(s.least, static_cast<double>(length) * options.spike_mm);
      const auto found = spike_near_others(longer, f, length);
      if (!found) continue;
      constexpr std::size_t around = 15;
      const FrameRange& frames = found->spike.frames;
      const std::size_t begin = frames.begin > around ? frames.begin - around : 0;
      const std::size_t end = std::min(bends.size(), frames.end + around);
      const FrameRange bent{frames.begin > 0 ? frames.begin - 1 : 0, frames.end + 1};
      const double local = robust_sd(bends, begin, end, bent);
      if (found->spike.deviation_mm >= options.spike_ratio * local) out.push_back(*found);
    }
  }
  return out;
}

/// Those without a sample between them as one. What is longer than a spike may be is none.
std::vector<Spike> joined(std::vector<Spike> spikes, std::ptrdiff_t longest, Path& path) {
  std::ranges::sort(spikes, {}, [](const Spike& s) { return s.frames.begin; });
  std::vector<Spike> out;
  for (const Spike& spike : spikes) {
    if (out.empty() || out.back().frames.end < spike.frames.begin) {
      out.push_back(spike);
      continue;
    }
    out.back().frames.end = spike.frames.end;
    out.back().deviation_mm = std::max(out.back().deviation_mm, spike.deviation_mm);
  }
  std::erase_if(out, [&](const Spike& spike) {
    if (static_cast<std::ptrdiff_t>(spike.frames.size()) <= longest) return false;
    for (std::size_t f = spike.frames.begin; f < spike.frames.end; ++f) path.seen[f] = 1;
    return true;
  });
  return out;
}

/// The clearest first: once they are out, the look around the others is free.
std::vector<Spike> spikes_of(Path& path, const LocalMotion& motion, std::size_t marker,
                             double rate_hz, const RepairOptions& options) {
  const std::vector<double> bends = accelerations(path);
  const double own = robust_sd(bends, 0, bends.size(), {});
  const Suspect suspect{path, motion, marker,
                        std::max(options.spike_mm, options.spike_ratio * own)};
  const std::ptrdiff_t longest = longest_spike(rate_hz, options);
  std::vector<Spike> out;
  constexpr int rounds = 8;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Finding> found = spikes_between(suspect, bends, longest, options);
    std::ranges::stable_sort(found, {}, &Finding::roughness);
    const std::size_t before = out.size();
    for (const Finding& spike : found) {
      constexpr auto apart = static_cast<std::size_t>(reach);
      const bool clear = std::none_of(
          out.begin() + static_cast<std::ptrdiff_t>(before), out.end(), [&](const Spike& other) {
            return spike.spike.frames.begin < other.frames.end + apart &&
                   other.frames.begin < spike.spike.frames.end + apart;
          });
      if (clear) out.push_back(spike.spike);
    }
    if (out.size() == before) break;
    for (std::size_t i = before; i < out.size(); ++i) {
      for (std::size_t f = out[i].frames.begin; f < out[i].frames.end; ++f) path.seen[f] = 0;
    }
  }
  return joined(std::move(out), longest, path);
}

}  // namespace

std::vector<Spike> find_spikes(const MarkerSequence& take, const RepairOptions& options,
                               const RunContext& ctx, bool at_ends) {
  std::vector<std::size_t> columns;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind == MarkerKind::marker) columns.push_back(m);
  }
  const LocalMotion motion = LocalMotion::of(take, columns);
  std::vector<std::vector<Spike>> found(columns.size());
  parallel_for(ctx, columns.size(), 4, [&](std::size_t k) {
    Path path = path_of(take, columns[k]);
    const std::vector<uint8_t> seen = path.seen;
    found[k] = spikes_of(path, motion, k, take.rate_hz, options);
    if (at_ends) {
      add_end_spikes(path, seen, motion, k, longest_spike(take.rate_hz, options), options,
                     found[k]);
    }
    std::ranges::sort(found[k], {}, [](const Spike& s) { return s.frames.begin; });
    for (Spike& spike : found[k]) spike.marker = columns[k];
  });
  std::vector<Spike> all;
  for (const auto& of_marker : found) all.insert(all.end(), of_marker.begin(), of_marker.end());
  return all;
}

}  // namespace kinemesh
