// What the methods of gap filling share: trajectories laid out marker by marker in double
// precision, and the estimate of one gap. Internal to gap filling.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/gaps.h"
#include "capture/marker_sequence.h"

namespace kinemesh::fill {

/// One contiguous run of frames × 3 per marker, mm. Samples that are not measured are never read
/// by a method.
class Trajectories {
 public:
  explicit Trajectories(const MarkerSequence& take);

  std::size_t frames() const { return frames_; }
  std::size_t markers() const { return markers_; }
  double rate_hz() const { return rate_hz_; }
  bool measured(std::size_t marker, std::size_t frame) const {
    return measured_[marker * frames_ + frame] != 0;
  }
  Eigen::Map<const Eigen::Vector3d> at(std::size_t marker, std::size_t frame) const {
    return Eigen::Map<const Eigen::Vector3d>(xyz_.data() + 3 * (marker * frames_ + frame));
  }
  /// Whether the marker is measured in every frame of the range.
  bool measured_throughout(std::size_t marker, FrameRange range) const;
  /// Mean over its measured frames; meaningless for a marker that has none.
  const Eigen::Vector3d& mean(std::size_t marker) const { return means_[marker]; }
  std::size_t measured_count(std::size_t marker) const { return counts_[marker]; }
  std::vector<FrameRange> gaps(std::size_t marker) const;

  /// Other markers with at least one measured frame, nearest (by mean position) first.
  std::vector<std::size_t> nearest(std::size_t marker) const;

  /// Takes an estimate as if it were measured (for helper passes on a copy).
  void put(std::size_t marker, std::size_t frame, const Eigen::Vector3d& position);
  /// Forgets samples (for leaving out known stretches on a copy).
  void forget(std::size_t marker, FrameRange range);

 private:
  void update(std::size_t marker);
  std::size_t frames_ = 0, markers_ = 0;
  double rate_hz_ = 0.0;
  std::vector<double> xyz_;
  std::vector<uint8_t> measured_;
  std::vector<Eigen::Vector3d> means_;
  std::vector<std::size_t> counts_;
};

/// One gap to fill: frames [frames.begin, frames.end) of a marker, none of them measured. Inside
/// the take it has a measured sample on both sides.
struct GapAt {
  std::size_t marker = 0;
  FrameRange frames;
};

/// Positions (mm) and standard deviations of one coordinate (mm), one per frame of the gap.
struct Estimate {
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> sd;
};

}  // namespace kinemesh::fill
