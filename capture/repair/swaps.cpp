// find_label_swaps() of repair.h.
#include <algorithm>
#include <cmath>

#include "capture/repair.h"
#include "capture/repair/local_motion.h"

namespace kinemesh {
namespace {

using repair::LocalMotion;
constexpr std::size_t none = MarkerSequence::npos;

class SwapFinder {
 public:
  SwapFinder(LocalMotion motion, double rate_hz)
      : motion_(std::move(motion)), last_seen_(motion_.markers(), none) {
    wait_ = std::max<std::size_t>(10, static_cast<std::size_t>(std::lround(1.5 * rate_hz)));
  }

  std::vector<LabelSwap> run(const RunContext& ctx) {
    std::vector<LabelSwap> found;
    for (std::size_t f = 0; f < motion_.frames(); ++f) {
      if (f % 256 == 0) ctx.check_cancelled();
      for (std::size_t a = 0; a < motion_.markers(); ++a) {
        if (!motion_.has(f, a) || last_seen_[a] == none || !jumped(a, f)) continue;
        if (const auto swap = explain(a, f)) {
          motion_.swap(swap->a, swap->b, f);
          found.push_back(*swap);
        }
      }
      for (std::size_t m = 0; m < motion_.markers(); ++m) {
        if (motion_.has(f, m)) last_seen_[m] = f;
      }
    }
    return found;
  }

 private:
  /// A first look: is the marker away from where its neighbours would have carried it?
  bool jumped(std::size_t a, std::size_t f) const {
    const std::size_t g = last_seen_[a];
    const double limit = least_jump(a);
    if (g + 1 == f) {
      const Eigen::Vector3d step = motion_.at(f, a) - motion_.at(g, a);
      if (step.squaredNorm() < limit * limit) return false;
      const auto common = motion_.displacement(a, g, f);
      if (!common || (step - *common).norm() < limit) return false;
    }
    return away(a, a, f, none) > limit;
  }

  double least_jump(std::size_t a) const {
    constexpr double share = 0.35;
    constexpr double least_mm = 1.5;
    return std::max(least_mm, share * motion_.spacing(a));
  }

  /// How far marker `who` in frame f is from where `whose` should be by its last sight before
  /// `since_`. `other` is not asked.
  double away(std::size_t who, std::size_t whose, std::size_t f, std::size_t other) const {
    const std::size_t g = last_seen_[whose];
    const Eigen::Vector3d there = motion_.carried(whose, motion_.at(g, whose), g, f, other);
    return (motion_.at(f, who) - there).norm();
  }

  /// The next frame from f on in which marker b is seen, within a while.
  std::size_t next_sight(std::size_t b, std::size_t f) const {
    for (std::size_t k = f; k < motion_.frames() && k <= f + wait_; ++k) {
      if (motion_.has(k, b)) return k;
    }
    return none;
  }

  std::optional<LabelSwap> explain(std::size_t a, std::size_t f) const {
    std::optional<LabelSwap> best;
    for (const std::size_t b : motion_.neighbours(a)) {
      if (last_seen_[b] == none) continue;
      const auto swap = judge(a, b, f);
      if (swap && (!best || swap->mended_mm < best->mended_mm)) best = swap;
    }
    return best;
  }

  /// Did a and b exchange their labels in frame f, in which a is seen?
  std::optional<LabelSwap> judge(std::size_t a, std::size_t b, std::size_t f) const {
    constexpr double ratio = 0.4;
    const double own = away(a, a, f, b);
    const double other = away(a, b, f, a);
    if (own < least_jump(a) || other > ratio * own) return std::nullopt;
    const std::size_t g = next_sight(b, f);
    if (g == none) return std::nullopt;
    const double own_b = away(b, b, g, a);
    const double other_b = away(b, a, g, b);
    if (own_b < least_jump(b) || other_b > ratio * own_b) return std::nullopt;
    if (!lasts(a, b, std::max(f, g))) return std::nullopt;
    return LabelSwap{a, b, f, 0.5 * (own + own_b), 0.5 * (other + other_b)};
  }

  /// A moment later they still are at each other's place: not two spikes.
  bool lasts(std::size_t a, std::size_t b, std::size_t f) const {
    constexpr std::size_t while_frames = 4;
    std::size_t kept = 0, seen = 0;
    for (std::size_t k = f + 1; k < motion_.frames() && k <= f + while_frames; ++k) {
      if (!motion_.has(k, a) || !motion_.has(k, b)) continue;
      ++seen;
      kept += away(a, b, k, a) < away(a, a, k, b) && away(b, a, k, b) < away(b, b, k, a) ? 1 : 0;
    }
    return kept == seen;
  }

  LocalMotion motion_;
  std::vector<std::size_t> last_seen_;  ///< before the frame looked at
  std::size_t wait_ = 0;
};

}  // namespace

std::vector<LabelSwap> find_label_swaps(const MarkerSequence& take, const RunContext& ctx) {
  std::vector<std::size_t> columns;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind == MarkerKind::marker) columns.push_back(m);
  }
  if (columns.size() < 3) return {};  // nothing says where two markers should be
  SwapFinder finder(LocalMotion::of(take, columns), take.rate_hz);
  std::vector<LabelSwap> swaps = finder.run(ctx);
  for (LabelSwap& s : swaps) {
    s.a = columns[s.a];
    s.b = columns[s.b];
  }
  return swaps;
}

}  // namespace kinemesh
