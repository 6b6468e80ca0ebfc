// The rigid frame that moves with a group of markers, frame by frame.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "capture/fill/trajectories.h"
#include "capture/rigid_fit.h"

namespace kinemesh::fill {

/// Positions of the markers in the given frames, and a weighted rigid fit of each to their mean
/// shape over the first `row_count` of them; markers that move more within it count less. With
/// fewer than four markers, or without rows, every pose is the identity.
class CommonFrame {
 public:
  /// `rounds`: refinements of the mean shape.
  CommonFrame(const Trajectories& rough, const std::vector<std::size_t>& markers,
              const std::vector<std::size_t>& frames, std::size_t row_count, int rounds);

  /// One position for each marker, mm, as recorded in the i-th frame.
  std::span<const Eigen::Vector3d> at(std::size_t i) const {
    return {positions_.data() + i * count_, count_};
  }
  /// Common frame → recording.
  const RigidFit& pose(std::size_t i) const { return poses_[i]; }
  std::size_t size() const { return poses_.size(); }
  /// Position of the k-th marker in the i-th frame, in the common frame.
  Eigen::Vector3d inside(std::size_t i, std::size_t k) const { return pose(i).undo(at(i)[k]); }
  /// Mean of that over the first `rows` frames.
  Eigen::Vector3d mean(std::size_t k, std::size_t rows) const;
  /// The i-th frame of those given from whose shape, as recorded, the mean shape starts: the axes
  /// of the common frame are nearly those of the recording there.
  static std::size_t first_shape(std::size_t row_count) { return row_count / 2; }

 private:
  void average(std::size_t row_count, std::vector<Eigen::Vector3d>& shape,
               std::vector<double>& weights) const;

  std::vector<RigidFit> poses_;
  std::vector<Eigen::Vector3d> positions_;
  std::size_t count_;
};

}  // namespace kinemesh::fill
