#include "capture/repair/strays.h"

#include <algorithm>
#include <cmath>

namespace kinemesh::repair {
namespace {

constexpr std::size_t none = MarkerSequence::npos;

}  // namespace

StrayFinder::StrayFinder(LocalMotion motion, double rate_hz)
    : motion_(std::move(motion)), recorded_(motion_), owned_(motion_.frames()) {
  constexpr double longest_s = 1.5;
  wait_ = std::max<std::size_t>(10, static_cast<std::size_t>(std::lround(longest_s * rate_hz)));
  for (std::size_t m = 0; m < motion_.markers(); ++m) {
    least_jump_.push_back(least_jump(motion_, m));
  }
}

std::vector<Stray> StrayFinder::run(const RunContext& ctx) {
  for (std::size_t m = 0; m < motion_.markers(); ++m) {
    ctx.check_cancelled();
    scan(m);
  }
  std::vector<Stray> out;
  for (const Stretch& stretch : stretches_) {
    for (std::size_t f = stretch.frames.begin; stretch.owner != none && f < stretch.frames.end;
         ++f) {
      owned_[f].push_back(stretch.owner);
      motion_.put(f, stretch.owner, recorded_.at(f, stretch.marker));
    }
  }
  for (const Stretch& stretch : stretches_) {
    const std::vector<Stray> pieces = share_out(stretch);
    if (pieces.empty()) put_back(stretch);
    out.insert(out.end(), pieces.begin(), pieces.end());
  }
  return out;
}

double StrayFinder::off(std::size_t m, std::size_t from, std::size_t f) const {
  return (motion_.at(f, m) - motion_.carried(m, motion_.at(from, m), from, f)).norm();
}

Eigen::Vector3d StrayFinder::between(std::size_t m, std::size_t before, std::size_t behind,
                                     std::size_t f) const {
  const double share = static_cast<double>(f - before) / static_cast<double>(behind - before);
  return (1.0 - share) * motion_.carried(m, motion_.at(before, m), before, f) +
         share * motion_.carried(m, motion_.at(behind, m), behind, f);
}

double StrayFinder::limit(std::size_t m, std::size_t frames) {
  std::size_t length = 1;
  while (length < frames) length *= 2;
  const auto known = limits_.find({m, length});
  if (known != limits_.end()) return known->second;
  return limits_[{m, length}] = limit(m, length, false, {});
}

double StrayFinder::limit(std::size_t m, std::size_t length, bool bridged,
                          const FrameRange& without) const {
  constexpr std::size_t most_samples = 48, fewest = 8;
  std::vector<double> usual;
  const std::size_t count = motion_.frames();
  const std::size_t stride = std::max<std::size_t>(1, count / most_samples);
  for (std::size_t f = 0; f + length < count; f += stride) {
    const std::size_t end = f + length;
    const std::size_t at = bridged ? f + length / 2 : end;
    const auto spoilt = [&](std::size_t k) { return without.begin <= k && k < without.end; };
    if (spoilt(f) || spoilt(at) || spoilt(end)) continue;
    if (!motion_.has(f, m) || !motion_.has(end, m) || !motion_.has(at, m)) continue;
    const Eigen::Vector3d there =
        bridged ? between(m, f, end, at) : motion_.carried(m, motion_.at(f, m), f, at);
    usual.push_back((motion_.at(at, m) - there).norm());
  }
  double value = std::max(least_jump_[m], motion_.spacing(m));
  if (usual.size() >= fewest) {
    std::ranges::sort(usual);
    value = std::max(least_jump_[m], 2.0 * usual[usual.size() * 95 / 100]);
  }
  return value;
}

/// A step that is far larger than the neighbours' and than those before and after it.
StrayFinder::Break StrayFinder::break_at(std::size_t m, std::size_t g, std::size_t f) const {
  if (g + 1 != f) return Break::gap;
  if ((motion_.at(f, m) - motion_.at(g, m)).norm() < least_jump_[m]) return Break::none;
  const auto step = [&](std::size_t from, std::size_t to) -> Eigen::Vector3d {
    const auto common = motion_.displacement(m, from, to);
    return motion_.at(to, m) - motion_.at(from, m) - common.value_or(Eigen::Vector3d::Zero());
  };
  const double size = step(g, f).norm();
  if (size < least_jump_[m]) return Break::none;
  constexpr double alone = 4.0;
  if (g > 0 && motion_.has(g - 1, m) && alone * step(g - 1, g).norm() > size) return Break::none;
  if (f + 1 < motion_.frames() && motion_.has(f + 1, m) && alone * step(f, f + 1).norm() > size) {
    return Break::none;
  }
  return Break::jump;
}

bool StrayFinder::follow(std::size_t m, std::size_t base, std::size_t f, int way, Break first,
                         Stretch& out) {
  out = {.marker = m};
  const double away = off(m, base, f);
  const std::size_t count = motion_.frames();
  std::size_t last = f;
  out.off.push_back(away);
  const bool gradually =
      first == Break::jump && away >= motion_.spacing(m);  // may it come back so?
  for (std::size_t i = 1; i <= wait_; ++i) {
    const std::size_t k = way > 0 ? f + i : f - i;
    if (k >= count) return finish(base, none, f, last, out);  // wraps below 0
    if (!motion_.has(k, m)) {
      out.off.push_back(-1.0);
      continue;
    }
    const Break second = way > 0 ? break_at(m, last, k) : break_at(m, k, last);
    if (second == Break::none && !gradually) {  // on as before
      out.off.push_back(away);
      last = k;
      continue;
    }
    const double distance = off(m, base, k);
    if (distance < 0.5 * away) {
      const double usual = limit(m, k > base ? k - base : base - k);
      const bool close = distance < std::max(least_jump_[m], 0.5 * usual);
      if (second != Break::none ? distance < usual : close) return finish(base, k, f, last, out);
    }
    if (distance < least_jump_[m]) return false;
    out.off.push_back(distance);
    last = k;
  }
  return false;
}

/// Is the stretch between `f` and `last` off, looked at from both sides? `home`: where the marker
/// is back; none: the take ends before.
bool StrayFinder::finish(std::size_t base, std::size_t home, std::size_t f, std::size_t last,
                         Stretch& out) {
  const std::size_t m = out.marker;
  out.open = home == none;
  out.frames = {std::min(f, last), std::max(f, last) + 1};
  out.off.resize(out.frames.size());
  if (last < f) std::ranges::reverse(out.off);
  const std::size_t first = out.open ? base : std::min(base, home);
  const std::size_t end = out.open ? last : std::max(base, home);
  std::vector<double> seen;
  for (std::size_t k = out.frames.begin; k < out.frames.end; ++k) {
    double& distance = out.off[k - out.frames.begin];
    if (distance < 0.0) continue;
    if (!out.open) distance = (motion_.at(k, m) - between(m, first, end, k)).norm();
    seen.push_back(distance);
  }
  const double size = median_of(seen);
  const double usual = limit(m, first < end ? end - first : first - end, !out.open, out.frames);
  constexpr double surely = 1.5;
  out.clear = !out.open && size >= surely * usual;
  return size >= usual;
}

void StrayFinder::take_out(const Stretch& stretch) {
  for (std::size_t f = stretch.frames.begin; f < stretch.frames.end; ++f) {
    motion_.forget(f, stretch.marker);
  }
}

void StrayFinder::put_back(const Stretch& stretch) {
  for (std::size_t f = stretch.frames.begin; f < stretch.frames.end; ++f) {
    if (recorded_.has(f, stretch.marker)) {
      motion_.put(f, stretch.marker, recorded_.at(f, stretch.marker));
    }
  }
}

void StrayFinder::scan(std::size_t m) {
  std::size_t home = none;
  for (std::size_t f = 0; f < motion_.frames(); ++f) {
    if (!motion_.has(f, m)) continue;
    const std::size_t g = home;
    home = f;
    if (g == none) continue;
    const Break found = break_at(m, g, f);
    if (found == Break::none) continue;
    const double distance = off(m, g, f);
    if (distance < least_jump_[m]) continue;
    Stretch behind, before;
    if (found == Break::jump && handed_over(m, f, distance)) continue;
    const bool goes = follow(m, g, f, 1, found, behind);
    const bool came = follow(m, f, g, -1, found, before);
    if (!goes && !came) continue;
    const bool onwards = goes && (!came || std::pair(behind.open, behind.frames.size()) <=
                                               std::pair(before.open, before.frames.size()));
    take_out(onwards ? behind : before);
    stretches_.push_back(std::move(onwards ? behind : before));
    if (onwards) home = g;
  }
}

/// The marker jumps away, and another one, not seen before, goes on where it was: what it had since
/// its last gap is that one's, if it fits to its last sight better.
bool StrayFinder::handed_over(std::size_t m, std::size_t f, double away) {
  constexpr double close = 0.4, better = 0.6;
  std::size_t begin = f;
  while (begin > 0 && motion_.has(begin - 1, m) && f - begin < wait_) --begin;
  const std::size_t own = last_sight(m, begin);
  if (f - begin >= wait_ || own == none) return false;
  for (std::size_t b = 0; b < motion_.markers(); ++b) {
    if (b == m || !motion_.has(f, b)) continue;
    const Eigen::Vector3d there = motion_.carried(b, motion_.at(f - 1, m), f - 1, f);
    if ((motion_.at(f, b) - there).norm() >= std::min(least_jump_[b], close * away)) continue;
    const std::size_t before = last_sight(b, f);
    if (before == none || before >= begin) continue;
    const Eigen::Vector3d led = motion_.carried(b, motion_.at(before, b), before, begin);
    const double strange = off(m, own, begin);
    if ((motion_.at(begin, m) - led).norm() >= better * strange) continue;
    Stretch stretch{.marker = m, .frames = {begin, f}, .owner = b};
    stretch.off.assign(f - begin, strange);
    take_out(stretch);
    stretches_.push_back(std::move(stretch));
    return true;
  }
  return false;
}

/// The last frame before `f` in which the marker is seen, within a while.
std::size_t StrayFinder::last_sight(std::size_t m, std::size_t f) const {
  for (std::size_t i = 1; i <= std::min(wait_, f); ++i) {
    if (motion_.has(f - i, m)) return f - i;
  }
  return none;
}

/// The marker that was not seen in frame f, and should be where the stretch is.
std::size_t StrayFinder::owner(const Stretch& stretch, std::size_t f,
                               std::vector<std::size_t>& taken) {
  constexpr double close = 0.4;
  const Eigen::Vector3d& here = recorded_.at(f, stretch.marker);
  std::size_t best = none;
  double least = close * stretch.off[f - stretch.frames.begin];
  for (std::size_t b = 0; b < motion_.markers(); ++b) {
    if (b == stretch.marker || motion_.has(f, b) || std::ranges::find(taken, b) != taken.end()) {
      continue;
    }
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double total = 0.0;
    std::size_t nearest = none;
    for (const int way : {-1, 1}) {
      for (std::size_t i = 1; i <= wait_; ++i) {
        const std::size_t k = way > 0 ? f + i : f - i;
        if (k >= motion_.frames()) break;
        if (!motion_.has(k, b)) continue;
        sum += motion_.carried(b, motion_.at(k, b), k, f) / static_cast<double>(i);
        total += 1.0 / static_cast<double>(i);
        nearest = std::min(nearest, i);
        break;
      }
    }
    if (nearest == none) continue;
    const double distance = (sum / total - here).norm();
    const double reach = std::max(least_jump_[b], 0.5 * motion_.spacing(b));
    if (distance >= std::min({least, limit(b, nearest), reach})) continue;
    least = distance;
    best = b;
  }
  return best;
}

/// The stretch by whose place it is at, frame by frame; what is too short for that, or nobody's, is
/// to go. Nothing when the stretch may be right after all.
std::vector<Stray> StrayFinder::share_out(const Stretch& stretch) {
  constexpr std::size_t fewest = 3;
  if (stretch.owner != none)
    return {{stretch.marker, stretch.frames, stretch.off[0], stretch.owner}};
  std::vector<Stray> pieces;
  std::size_t seen = 0, given = 0;
  for (std::size_t f = stretch.frames.begin; f < stretch.frames.end; ++f) {
    const double distance = stretch.off[f - stretch.frames.begin];
    if (distance < 0.0) continue;
    ++seen;
    const std::size_t b = owner(stretch, f, owned_[f]);
    const std::optional<std::size_t> to = b == none ? std::nullopt : std::optional(b);
    if (pieces.empty() || pieces.back().owner != to) {
      pieces.push_back({stretch.marker, {f, f + 1}, distance, to});
    }
    pieces.back().frames.end = f + 1;
    pieces.back().off_mm = std::max(pieces.back().off_mm, distance);
  }
  std::vector<Stray> out;
  for (Stray& piece : pieces) {
    if (pieces.size() > 1 && piece.frames.size() < fewest) piece.owner.reset();
    if (piece.owner) given += piece.frames.size();
    if (!out.empty() && out.back().owner == piece.owner) {
      out.back().frames.end = piece.frames.end;
      out.back().off_mm = std::max(out.back().off_mm, piece.off_mm);
    } else {
      out.push_back(piece);
    }
  }
  const bool owned = 10 * given >= 9 * seen;  // nearly all of it
  if (!owned && (stretch.open || !stretch.clear)) return {};
  for (const Stray& piece : out) {
    for (std::size_t f = piece.frames.begin; piece.owner && f < piece.frames.end; ++f) {
      owned_[f].push_back(*piece.owner);
    }
  }
  return out;
}

}  // namespace kinemesh::repair

namespace kinemesh {

std::vector<Stray> find_strays(const MarkerSequence& take, const RunContext& ctx) {
  std::vector<std::size_t> columns;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind == MarkerKind::marker) columns.push_back(m);
  }
  if (columns.size() < 4) return {};  // nothing says where one should be
  std::vector<Stray> strays =
      repair::StrayFinder(repair::LocalMotion::of(take, columns), take.rate_hz).run(ctx);
  for (Stray& stray : strays) {
    stray.marker = columns[stray.marker];
    if (stray.owner) stray.owner = columns[*stray.owner];
  }
  return strays;
}

}  // namespace kinemesh
