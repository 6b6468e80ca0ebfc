// Where a marker should be, from what its neighbours did meanwhile. Internal to repair and
// labelling.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/marker_sequence.h"
#include "capture/measured.h"

namespace kinemesh::repair {

/// Positions by frame and marker, and the neighbours of each marker.
class LocalMotion {
 public:
  /// `places`: one per marker, mm; the nearest others there are its neighbours. NaN: none.
  LocalMotion(std::size_t frames, const std::vector<Eigen::Vector3d>& places);
  /// The measured samples of these columns; places are medians over the take.
  static LocalMotion of(const MarkerSequence& take, std::span<const std::size_t> columns);

  std::size_t frames() const { return frames_; }
  std::size_t markers() const { return markers_; }
  bool has(std::size_t f, std::size_t m) const { return seen_[f * markers_ + m] != 0; }
  const Eigen::Vector3d& at(std::size_t f, std::size_t m) const {
    return positions_[f * markers_ + m];
  }
  void put(std::size_t f, std::size_t m, const Eigen::Vector3d& p);
  void forget(std::size_t f, std::size_t m) { seen_[f * markers_ + m] = 0; }
  void swap(std::size_t a, std::size_t b, std::size_t from);

  const std::vector<std::size_t>& neighbours(std::size_t m) const { return neighbours_[m]; }
  /// Distance to the nearest other place, mm.
  double spacing(std::size_t m) const { return spacing_[m]; }

  /// Where what was at `position` beside marker m in frame `from` is in frame `to`: carried by the
  /// rigid motion of the neighbours seen in both (the worst two of them set aside), by their median
  /// displacement when they are fewer than four, or not at all when there is none. `without`:
  /// other markers not to be asked.
  Eigen::Vector3d carried(std::size_t m, const Eigen::Vector3d& position, std::size_t from,
                          std::size_t to, std::span<const std::size_t> without = {}) const;
  /// Median displacement of the neighbours seen in both frames; nothing when there is none.
  std::optional<Eigen::Vector3d> displacement(std::size_t m, std::size_t from,
                                              std::size_t to) const;

 private:
  std::size_t frames_ = 0, markers_ = 0;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<uint8_t> seen_;
  std::vector<std::vector<std::size_t>> neighbours_;
  std::vector<double> spacing_;
};

/// What is more than noise and motion make from frame to frame, and leads towards another marker:
/// 1.5 mm, 0.35 × the distance to the nearest marker, 3 × the median of how far the marker's step
/// from one frame to the next is from that of its neighbours (a normal deviation in space exceeds
/// that once in 10,000 frames). Where noise is as large as that distance, nothing can be said.
double least_jump(const LocalMotion& motion, std::size_t m);

/// Reorders `values`, which must not be empty.
double median_of(std::vector<double>& values);

}  // namespace kinemesh::repair
