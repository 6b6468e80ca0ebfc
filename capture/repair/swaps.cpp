// find_label_swaps() of repair.h.
#include <algorithm>
#include <cmath>
#include <span>

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
    for (std::size_t m = 0; m < motion_.markers(); ++m)
      least_jump_.push_back(repair::least_jump(motion_, m));
  }

  std::vector<LabelSwap> run(const RunContext& ctx) {
    std::vector<LabelSwap> found;
    for (std::size_t f = 0; f < motion_.frames(); ++f) {
      if (f % 256 == 0) ctx.check_cancelled();
      for (std::size_t a = 0; a < motion_.markers(); ++a) {
        if (!motion_.has(f, a) || last_seen_[a] == none || !jumped(a, f)) continue;
        std::vector<LabelSwap> swaps;
        if (const auto swap = explain(a, f)) {
          swaps.push_back(*swap);
        } else {
          swaps = explain_round(a, f);
        }
        for (const LabelSwap& swap : swaps) motion_.swap(swap.a, swap.b, f);
        found.insert(found.end(), swaps.begin(), swaps.end());
        if (swaps.empty() && stays_away(a, f)) jumps_.push_back({a, f, away(a, a, f)});
      }
      for (std::size_t m = 0; m < motion_.markers(); ++m) {
        if (motion_.has(f, m)) last_seen_[m] = f;
      }
    }
    return found;
  }
  const std::vector<Jump>& jumps() const { return jumps_; }

 private:
  /// One step alone is far larger than those before and after it, and the marker does not come back
  /// within a while.
  bool stays_away(std::size_t a, std::size_t f) const {
    constexpr double alone = 4.0;
    constexpr std::size_t while_frames = 5;
    const std::size_t g = last_seen_[a];
    if (g + 1 != f || g < 2 || f + while_frames >= motion_.frames()) return false;
    const double size = away(a, a, f);
    for (const std::size_t k : {g - 1, g, f + 1, f + 2}) {
      if (!motion_.has(k, a) || !motion_.has(k - 1, a)) return false;
      const Eigen::Vector3d common =
          motion_.displacement(a, k - 1, k).value_or(Eigen::Vector3d::Zero());
      const Eigen::Vector3d step = motion_.at(k, a) - motion_.at(k - 1, a);
      if (alone * (step - common).norm() > size) return false;
    }
    for (std::size_t k = f + 1; k <= f + while_frames; ++k) {
      if (motion_.has(k, a) && away(a, a, k) < 0.5 * size) return false;
    }
    return true;
  }

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
    return away(a, a, f) > limit;
  }

  double least_jump(std::size_t a) const { return least_jump_[a]; }

  /// How far marker `who` in frame f is from where `whose` should be by its last sight before the
  /// frame looked at. `others` are not asked.
  double away(std::size_t who, std::size_t whose, std::size_t f,
              std::span<const std::size_t> others) const {
    const std::size_t g = last_seen_[whose];
    const Eigen::Vector3d there = motion_.carried(whose, motion_.at(g, whose), g, f, others);
    return (motion_.at(f, who) - there).norm();
  }
  double away(std::size_t who, std::size_t whose, std::size_t f) const {
    return away(who, whose, f, {});
  }
  double away(std::size_t who, std::size_t whose, std::size_t f, std::size_t other) const {
    return away(who, whose, f, std::span(&other, 1));
  }

  /// The next frame from f on in which marker b is seen, within a while.
  std::size_t next_sight(std::size_t b, std::size_t f) const {
    for (std::size_t k = f; k < motion_.frames() && k <= f + wait_; ++k) {
      if (motion_.has(k, b)) return k;
    }
    return none;
  }

  /// Any other marker may have the label, near or far; few are where `a` is now.
  std::optional<LabelSwap> explain(std::size_t a, std::size_t f) const {
    std::optional<LabelSwap> best;
    for (std::size_t b = 0; b < motion_.markers(); ++b) {
      if (b == a || last_seen_[b] == none || !may_be_at(b, motion_.at(f, a), a, f)) continue;
      const auto swap = judge(a, b, f);
      if (swap && (!best || swap->mended_mm < best->mended_mm)) best = swap;
    }
    return best;
  }

  /// A first look: was marker b, moved with its neighbours, closer to `place` than `a` was?
  bool may_be_at(std::size_t b, const Eigen::Vector3d& place, std::size_t a, std::size_t f) const {
    const auto from = [&](std::size_t m) {
      const std::size_t g = last_seen_[m];
      const Eigen::Vector3d common =
          motion_.displacement(m, g, f).value_or(Eigen::Vector3d::Zero());
      return (motion_.at(g, m) + common - place).norm();
    };
    return from(b) < from(a);
  }

  /// Did a and b exchange their labels in frame f, in which a is seen?
  std::optional<LabelSwap> judge(std::size_t a, std::size_t b, std::size_t f) const {
    constexpr double ratio = 0.4;
    const double own = away(a, a, f, b);
    const double other = away(a, b, f, a);
    if (own < least_jump(a) || other > ratio * own) return std::nullopt;
    // Its first sight may be spoilt by a spike.
    constexpr std::size_t looks = 4;
    std::size_t g = next_sight(b, f);
    double own_b = 0.0, other_b = 0.0;
    for (std::size_t look = 0; look < looks && g != none; ++look, g = next_sight(b, g + 1)) {
      own_b = away(b, b, g, a);
      other_b = away(b, a, g, b);
      if (own_b < least_jump(b)) return std::nullopt;
      if (other_b <= ratio * own_b) break;
    }
    if (g == none || other_b > ratio * own_b) return std::nullopt;
    if (!lasts(a, b, std::max(f, g))) return std::nullopt;
    return LabelSwap{.a = a,
                     .b = b,
                     .from = f,
                     .until = {},
                     .error_mm = 0.5 * (own + own_b),
                     .mended_mm = 0.5 * (other + other_b)};
  }

  /// A moment later they still are at each other's place, or both are back at their own: not two
  /// spikes.
  bool lasts(std::size_t a, std::size_t b, std::size_t f) const {
    constexpr std::size_t while_frames = 4;
    bool back = false;
    for (std::size_t k = f + 1; k < motion_.frames() && k <= f + while_frames; ++k) {
      if (!motion_.has(k, a) || !motion_.has(k, b)) continue;
      const bool a_away = away(a, b, k, a) < away(a, a, k, b);
      const bool b_away = away(b, a, k, b) < away(b, b, k, a);
      if (a_away != b_away || (back && a_away)) return false;
      back = !a_away;
    }
    return true;
  }

  // ---- three or more labels that go round
  // --------------------------------------------------------

  /// All markers that jump in frame f, `a` among them.
  std::vector<std::size_t> jumping(std::size_t a, std::size_t f) const {
    std::vector<std::size_t> all;
    for (std::size_t m = 0; m < motion_.markers(); ++m) {
      if (m == a || (motion_.has(f, m) && last_seen_[m] != none && jumped(m, f))) all.push_back(m);
    }
    return all;
  }

  /// Whose place does marker `who` take in frame f, much closer than its own?
  std::size_t taken_by(std::size_t who, std::size_t f, std::span<const std::size_t> others) const {
    constexpr double ratio = 0.4;
    const double own = away(who, who, f, others);
    if (own < least_jump(who)) return none;
    std::size_t best = none;
    double least = ratio * own;
    for (std::size_t b = 0; b < motion_.markers(); ++b) {
      if (b == who || last_seen_[b] == none || !may_be_at(b, motion_.at(f, who), who, f)) continue;
      const double off = away(who, b, f, others);
      if (off >= least) continue;
      least = off;
      best = b;
    }
    return best;
  }

  /// From marker to marker: each is at the place of the next, the last at that of the first. As
  /// exchanges of two, which undo it one after the other; empty when the round does not close.
  std::vector<LabelSwap> explain_round(std::size_t a, std::size_t f) const {
    constexpr std::size_t longest = 8;
    std::vector<std::size_t> others = jumping(a, f);
    std::vector<std::size_t> round{a};
    std::vector<std::size_t> frames{f};
    while (true) {
      const std::size_t next = taken_by(round.back(), frames.back(), others);
      if (next == a && round.size() > 2) break;
      if (next == none || round.size() == longest || std::ranges::find(round, next) != round.end())
        return {};
      const std::size_t g = next_sight(next, f);
      if (g == none) return {};
      round.push_back(next);
      frames.push_back(g);
      if (std::ranges::find(others, next) == others.end()) others.push_back(next);
    }
    if (!round_lasts(round, others, *std::ranges::max_element(frames))) return {};
    LabelSwap swap{.a = a, .from = f, .of = round.size()};
    for (std::size_t i = 0; i < round.size(); ++i) {
      const std::size_t place = round[(i + 1) % round.size()];
      swap.error_mm += away(round[i], round[i], frames[i], others) / static_cast<double>(swap.of);
      swap.mended_mm += away(round[i], place, frames[i], others) / static_cast<double>(swap.of);
    }
    std::vector<LabelSwap> out;
    for (std::size_t i = 1; i < round.size(); ++i) {
      swap.b = round[i];
      out.push_back(swap);
    }
    return out;
  }

  /// A moment later they are all still at the place of the next, or all back at their own.
  bool round_lasts(const std::vector<std::size_t>& round, const std::vector<std::size_t>& others,
                   std::size_t f) const {
    constexpr std::size_t while_frames = 4;
    bool back = false;
    for (std::size_t k = f + 1; k < motion_.frames() && k <= f + while_frames; ++k) {
      std::size_t seen = 0, elsewhere = 0;
      for (std::size_t i = 0; i < round.size(); ++i) {
        if (!motion_.has(k, round[i])) continue;
        const std::size_t next = round[(i + 1) % round.size()];
        ++seen;
        elsewhere += away(round[i], next, k, others) < away(round[i], round[i], k, others) ? 1 : 0;
      }
      if ((elsewhere != 0 && elsewhere != seen) || (back && elsewhere != 0)) return false;
      back = seen != 0 && elsewhere == 0;
    }
    return true;
  }

  LocalMotion motion_;
  std::vector<std::size_t> last_seen_;  ///< before the frame looked at
  std::vector<double> least_jump_;      ///< by marker, mm
  std::vector<Jump> jumps_;
  std::size_t wait_ = 0;
};

/// One exchange within the first third of the take: the frames before it have the wrong labels, not
/// the rest.
void mend_beginnings(std::vector<LabelSwap>& swaps, std::size_t frames) {
  const std::size_t first_frames = frames / 3;
  for (auto begin = swaps.begin(); begin != swaps.end();) {
    const auto end = begin + static_cast<std::ptrdiff_t>(begin->of - 1);
    const auto concerned = [&](std::size_t m) {
      return std::any_of(begin, end, [&](const LabelSwap& s) { return s.a == m || s.b == m; });
    };
    const auto again = [&](const LabelSwap& s) { return concerned(s.a) || concerned(s.b); };
    const bool once =
        std::none_of(swaps.begin(), begin, again) && std::none_of(end, swaps.end(), again);
    if (once && begin->from <= first_frames) {
      std::reverse(begin, end);  // the other way round, to do there what was undone behind
      for (auto swap = begin; swap != end; ++swap) {
        swap->until = swap->from;
        swap->from = 0;
      }
    }
    begin = end;
  }
}

}  // namespace

std::size_t count_swaps(const std::vector<LabelSwap>& swaps) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < swaps.size(); i += std::max<std::size_t>(swaps[i].of, 2) - 1) ++count;
  return count;
}

std::vector<LabelSwap> find_label_swaps(const MarkerSequence& take, const RunContext& ctx,
                                        std::vector<Jump>* jumps) {
  std::vector<std::size_t> columns;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind == MarkerKind::marker) columns.push_back(m);
  }
  if (columns.size() < 3) return {};  // nothing says where two markers should be
  SwapFinder finder(LocalMotion::of(take, columns), take.rate_hz);
  std::vector<LabelSwap> swaps = finder.run(ctx);
  mend_beginnings(swaps, take.frame_count());
  for (LabelSwap& s : swaps) {
    s.a = columns[s.a];
    s.b = columns[s.b];
  }
  for (Jump jump : finder.jumps()) {
    if (jumps == nullptr) break;
    jump.marker = columns[jump.marker];
    jumps->push_back(jump);
  }
  return swaps;
}

}  // namespace kinemesh
