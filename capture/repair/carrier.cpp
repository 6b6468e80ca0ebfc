#include "capture/repair/carrier.h"

#include <algorithm>
#include <cmath>

namespace kinemesh::repair {

LabelCarrier::LabelCarrier(std::vector<LoosePoints>& points, LocalMotion& motion,
                           std::vector<Eigen::Vector3d> start, std::size_t frame)
    : points_(points), motion_(motion), start_(std::move(start)), frame_(frame) {}

void LabelCarrier::run() {
  State forwards{start_, std::vector<std::size_t>(start_.size(), frame_)};
  State backwards = forwards;
  for (std::size_t f = frame_; f + 1 < motion_.frames(); ++f) step(forwards, f, f + 1);
  for (std::size_t f = frame_; f > 0; --f) step(backwards, f, f - 1);
}

/// One frame further by the label's own motion and that of its neighbours, averaged.
Eigen::Vector3d LabelCarrier::ahead(const State& state, std::size_t label, std::size_t from,
                                    std::size_t to) const {
  const std::size_t before = from + from - to;  // wraps for from = 0 going on: then out of range
  const bool inside = before < motion_.frames();
  if (!inside) return state.last[label];
  const auto common = motion_.displacement(label, before, from);
  Eigen::Vector3d step = common.value_or(Eigen::Vector3d::Zero());
  if (motion_.has(before, label)) {
    const Eigen::Vector3d own = motion_.at(from, label) - motion_.at(before, label);
    step = common ? Eigen::Vector3d(0.5 * (own + *common)) : own;
  }
  return state.last[label] + step;
}

void LabelCarrier::offer(std::size_t label, const Eigen::Vector3d& place, double reach,
                         std::size_t frame, std::vector<Link>& links) const {
  const LoosePoints& here = points_[frame];
  for (std::size_t i = 0; i < here.positions.size(); ++i) {
    if (here.labels[i] >= 0) continue;
    const double square = (here.positions[i] - place).squaredNorm();
    if (square < reach * reach) links.push_back({square, label, i});
  }
}

void LabelCarrier::assign(std::vector<Link>& links, std::size_t frame) {
  std::ranges::sort(links, [](const Link& a, const Link& b) {
    return a.cost != b.cost ? a.cost < b.cost
                            : std::pair(a.label, a.point) < std::pair(b.label, b.point);
  });
  LoosePoints& here = points_[frame];
  for (const Link& link : links) {
    if (here.labels[link.point] >= 0 || motion_.has(frame, link.label)) continue;
    here.labels[link.point] = static_cast<int>(link.label);
    motion_.put(frame, link.label, here.positions[link.point]);
  }
}

void LabelCarrier::step(State& state, std::size_t from, std::size_t to) {
  constexpr double share = 0.6;     // of the distance to the nearest other label
  constexpr double least_mm = 2.5;  // noise and acceleration of a frame
  constexpr double most_mm = 15.0;
  std::vector<Link> links;
  const auto reach = [&](std::size_t label, double most) {
    return std::clamp(share * motion_.spacing(label), least_mm, most);
  };
  for (std::size_t m = 0; m < state.last.size(); ++m) {
    if (motion_.has(to, m) || state.seen[m] != from || !motion_.has(from, m)) continue;
    offer(m, ahead(state, m, from, to), reach(m, most_mm), to, links);
  }
  assign(links, to);
  links.clear();
  for (std::size_t m = 0; m < state.last.size(); ++m) {
    if (motion_.has(to, m)) continue;
    const bool any_free = std::ranges::any_of(points_[to].labels, [](int l) { return l < 0; });
    if (!any_free) break;
    const Eigen::Vector3d place = motion_.carried(m, state.last[m], state.seen[m], to);
    offer(m, place, reach(m, most_mm), to, links);
  }
  assign(links, to);
  for (std::size_t m = 0; m < state.last.size(); ++m) {
    if (!motion_.has(to, m)) continue;
    state.last[m] = motion_.at(to, m);
    state.seen[m] = to;
  }
}

}  // namespace kinemesh::repair
