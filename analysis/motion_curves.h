// Curves over time that say when, not where, a surface moves: what two performances are brought
// into the same time by, before it is known which point corresponds to which.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "analysis/deformation.h"
#include "mesh/topology.h"

namespace kinemesh {

struct MotionCurves {
  double rate_hz = 0.0;
  std::size_t frame_count = 0;
  std::size_t channel_count = 0;
  std::vector<double> values;  ///< frames × channels

  MotionCurves() = default;
  MotionCurves(std::size_t frames, std::size_t channels, double rate)
      : rate_hz(rate),
        frame_count(frames),
        channel_count(channels),
        values(frames * channels, 0.0) {}
  double& at(std::size_t frame, std::size_t channel) {
    return values[frame * channel_count + channel];
  }
  double at(std::size_t frame, std::size_t channel) const {
    return values[frame * channel_count + channel];
  }
  double duration_s() const {
    return frame_count > 1 ? static_cast<double>(frame_count - 1) / rate_hz : 0.0;
  }
};

/// How deformation is distributed over the surface in each frame: its 50, 75, 90, 95 and 99 %
/// quantiles over the vertices, each weighted by its area in the rest pose. Needs no
/// correspondence, and is the same whatever the position, the size and the triangulation.
MotionCurves motion_signature(const AnimatedMesh& animation, const DeformationResult& deformation);

/// A channel for each vertex: of two animations at corresponding vertices, for a closer comparison.
MotionCurves curves_of(const VertexCurves& curves, std::span<const VertexIndex> vertices,
                       double rate_hz);

}  // namespace kinemesh
