// The hot loop of driving: rest + spread · displacements for many frames at once.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "config/run_context.h"

namespace kinemesh {

/// The spread matrix packed for the product: rows in groups of four, marker by marker.
class PackedSpread {
 public:
  explicit PackedSpread(const Eigen::MatrixXf& spread);
  std::size_t vertices() const { return vertices_; }
  std::size_t markers() const { return markers_; }

  /// Writes frames × vertices × 3 floats to `out`: rest (3 per vertex) plus the spread
  /// displacements (markers × 3 frames, column 3 f + axis). Two floating-point operations for each
  /// frame, vertex, marker and axis; the same bytes for any number of threads and any instruction
  /// set.
  void apply(std::span<const float> rest, const Eigen::MatrixXf& displacements,
             std::span<float> out, const RunContext& ctx = {}) const;

 private:
  std::size_t vertices_ = 0, markers_ = 0;
  std::vector<float> packed_;  // groups × markers × 4
};

}  // namespace kinemesh
