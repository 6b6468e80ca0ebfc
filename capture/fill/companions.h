// Gap filling from other markers without statistics: the motion of a donor, or of companions
// taken as a rigid body.
#pragma once

#include <span>

#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// Adds to a guess the difference to the measured samples at both sides of the gap, linearly
/// interpolated in between and constant at the ends of the take, so that nothing jumps.
/// `guess_at(frame)` is called for the frames of the gap and for the one on either side.
template <class Guess>
Estimate bridge(const Trajectories& take, const GapAt& gap, Guess guess_at) {
  const FrameRange frames = gap.frames;
  const bool left = frames.begin > 0;
  const bool right = frames.end < take.frames();
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  Eigen::Vector3d after = Eigen::Vector3d::Zero();
  if (left) before = take.at(gap.marker, frames.begin - 1) - guess_at(frames.begin - 1);
  if (right) after = take.at(gap.marker, frames.end) - guess_at(frames.end);
  if (!left) before = after;
  if (!right) after = before;
  Estimate out;
  out.positions.reserve(frames.size());
  for (std::size_t f = frames.begin; f < frames.end; ++f) {
    const double u =
        static_cast<double>(f + 1 - frames.begin) / static_cast<double>(frames.size() + 1);
    out.positions.push_back(guess_at(f) + (1.0 - u) * before + u * after);
  }
  return out;
}

/// Of `candidates` (in their order), those measured throughout the gap and in the frame on each of
/// its sides, at most `most` of them.
std::vector<std::size_t> seen_throughout(const Trajectories& take, const GapAt& gap,
                                         std::span<const std::size_t> candidates, std::size_t most);

/// The donor's motion, moved so that it meets the measured samples at both sides. Nothing when the
/// donor is not measured throughout the gap and beside it.
std::optional<Estimate> fill_pattern(const Trajectories& take, const GapAt& gap, std::size_t donor);

/// The pose of the companions carries the marker; where the marker lies relative to them is taken
/// from both sides of the gap. Nothing with fewer than three companions or when they stand on one
/// line.
std::optional<Estimate> fill_rigid(const Trajectories& take, const GapAt& gap,
                                   std::span<const std::size_t> companions);

/// The marker stays where it was last (and first) seen, moving on a straight line in between.
Estimate fill_hold(const Trajectories& take, const GapAt& gap);

}  // namespace kinemesh::fill
