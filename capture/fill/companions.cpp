#include "capture/fill/companions.h"

#include <algorithm>

#include "capture/rigid_fit.h"

namespace kinemesh::fill {

std::vector<std::size_t> seen_throughout(const Trajectories& take, const GapAt& gap,
                                         std::span<const std::size_t> candidates,
                                         std::size_t most) {
  const FrameRange wanted{gap.frames.begin > 0 ? gap.frames.begin - 1 : 0,
                          std::min(gap.frames.end + 1, take.frames())};
  std::vector<std::size_t> out;
  for (const std::size_t m : candidates) {
    if (out.size() == most) break;
    if (m != gap.marker && take.measured_throughout(m, wanted)) out.push_back(m);
  }
  return out;
}

std::optional<Estimate> fill_pattern(const Trajectories& take, const GapAt& gap,
                                     std::size_t donor) {
  if (seen_throughout(take, gap, std::span(&donor, 1), 1).empty()) return std::nullopt;
  return bridge(take, gap, [&](std::size_t f) -> Eigen::Vector3d { return take.at(donor, f); });
}

std::optional<Estimate> fill_rigid(const Trajectories& take, const GapAt& gap,
                                   std::span<const std::size_t> companions) {
  const std::vector<std::size_t> seen = seen_throughout(take, gap, companions, companions.size());
  if (seen.size() < 3) return std::nullopt;
  const std::size_t reference = gap.frames.begin > 0 ? gap.frames.begin - 1 : gap.frames.end;
  const auto shape_at = [&](std::size_t f) {
    std::vector<Eigen::Vector3d> points;
    points.reserve(seen.size());
    for (const std::size_t m : seen) points.emplace_back(take.at(m, f));
    return points;
  };
  const std::vector<Eigen::Vector3d> rest = shape_at(reference);
  const auto pose_at = [&](std::size_t f) { return fit_rigid(rest, shape_at(f)); };
  constexpr double thinnest_mm = 1.0;  // companions closer to one line leave the turn about it open
  if (pose_at(reference).spread < thinnest_mm) return std::nullopt;

  const bool left = gap.frames.begin > 0;
  const bool right = gap.frames.end < take.frames();
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  Eigen::Vector3d after = Eigen::Vector3d::Zero();
  if (left) before = take.at(gap.marker, gap.frames.begin - 1);  // the pose there is the identity
  if (right) after = pose_at(gap.frames.end).undo(take.at(gap.marker, gap.frames.end));
  if (!left) before = after;
  if (!right) after = before;
  Estimate out;
  for (std::size_t f = gap.frames.begin; f < gap.frames.end; ++f) {
    const double u =
        static_cast<double>(f + 1 - gap.frames.begin) / static_cast<double>(gap.frames.size() + 1);
    out.positions.push_back(pose_at(f).apply((1.0 - u) * before + u * after));
  }
  return out;
}

Estimate fill_hold(const Trajectories& take, const GapAt& gap) {
  return bridge(take, gap, [&](std::size_t) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); });
}

}  // namespace kinemesh::fill
