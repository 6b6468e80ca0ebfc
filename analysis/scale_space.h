// Smoothing of vertex curves over the surface, and the levels of the scale space of one tile of
// vertices. Private to analysis/.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "analysis/anim_dog.h"
#include "analysis/diffusion.h"
#include "config/buffer.h"

namespace kinemesh::scale_space {

/// Vertices renumbered so that neighbours are close: row r holds vertex order[r].
struct RowOrder {
  std::vector<VertexIndex> order;
  std::vector<uint32_t> row_of;
};
RowOrder breadth_first(const Topology& topology);

/// The rows around each row, and the ring average over them: out[r] = in[r] + Σ weights ·
/// (in[items] − in[r]).
struct SurfaceFilter {
  std::vector<uint32_t> offsets;
  std::vector<uint32_t> items;
  std::vector<float> weights;  ///< per item: 1 / (ring + 1)
  std::vector<float> step;     ///< per row: mean squared step per axis of one average, mm²
};
SurfaceFilter ring_filter(const Topology& topology, const RowOrder& order,
                          std::span<const Eigen::Vector3d> rest);
/// From one level to the next: ring averages, or implicit diffusion where there is a factor.
struct LevelStep {
  int passes = 1;
  std::shared_ptr<const diffusion::Factor> factor{};
};

/// The spatial levels: σ of each, and how to get from one to the next.
struct SpatialLevels {
  SurfaceFilter filter;
  std::vector<double> variances;  ///< mm², per axis, mean over the mesh; levels + 1
  /// Ring filter: the variance at each row, rows × (levels + 1); empty otherwise.
  std::vector<float> local_variances;
  float offset = 0.0F;           ///< taken off the scalar first: D does not feel it, rounding does
  std::vector<LevelStep> steps;  ///< steps[0] leads to level 0, steps[k] from k − 1 to k
  double passes() const;
};

/// Several frames of all rows, smoothed in place of each other.
class FrameBlock {
 public:
  static constexpr std::size_t lanes = 16;
  /// Frames [first, first + frames) of the scalar, less `offset`.
  FrameBlock(const VertexCurves& scalar, const RowOrder& order, std::size_t first,
             std::size_t frames, float offset = 0.0F);
  void smooth(const SurfaceFilter& filter, const LevelStep& step);
  const float* row(std::size_t r) const { return current_.data() + r * stride_; }

 private:
  std::size_t rows_, stride_;
  Buffer<float> current_, next_;
};

/// The levels of the rows of one tile and of their neighbours: slots × levels × frames.
struct TileLevels {
  std::size_t begin = 0, end = 0;  ///< rows of the tile
  std::size_t level_count = 0, frame_count = 0;
  std::vector<uint32_t> rows;     ///< row of each slot; the tile's own first
  std::vector<uint32_t> slot_of;  ///< per row, or invalid_index
  Buffer<float> values;
  const float* level(std::size_t slot, std::size_t k) const {
    return values.data() + (slot * level_count + k) * frame_count;
  }
  float* level(std::size_t slot, std::size_t k) {
    return values.data() + (slot * level_count + k) * frame_count;
  }
};
TileLevels make_tile(const SpatialLevels& levels, const RowOrder& order, const VertexCurves& scalar,
                     std::size_t begin, std::size_t end, const RunContext& ctx);

}  // namespace kinemesh::scale_space
