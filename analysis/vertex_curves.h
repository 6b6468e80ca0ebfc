// A scalar per vertex and frame, the frames of each vertex side by side in memory.
#pragma once

#include <cstddef>
#include <span>

#include "config/buffer.h"

namespace kinemesh {

struct VertexCurves {
  std::size_t vertex_count = 0;
  std::size_t frame_count = 0;
  Buffer<float> values;  ///< vertices × frames

  VertexCurves() = default;
  /// Uninitialised.
  VertexCurves(std::size_t vertices, std::size_t frames)
      : vertex_count(vertices), frame_count(frames), values(vertices * frames) {}
  std::span<float> of(std::size_t vertex) {
    return {values.data() + vertex * frame_count, frame_count};
  }
  std::span<const float> of(std::size_t vertex) const {
    return {values.data() + vertex * frame_count, frame_count};
  }
};

}  // namespace kinemesh
