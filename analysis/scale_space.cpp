#include "analysis/scale_space.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "analysis/flush_denormals.h"
#include "analysis/surface_balls.h"
#include "config/multiversion.h"
#include "config/parallel.h"

namespace kinemesh::scale_space {
namespace {

constexpr std::size_t lanes = FrameBlock::lanes;

KINEMESH_MULTIVERSION void smooth_rows(const float* in, float* out, std::size_t stride,
                                       const uint32_t* offsets, const uint32_t* items,
                                       const float* weights, std::size_t rows) {
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t b = 0; b < stride; b += lanes) {
      const float* centre = in + r * stride + b;
      float sum[lanes] = {};
      float mine[lanes];
      for (std::size_t f = 0; f < lanes; ++f) mine[f] = centre[f];
      for (uint32_t i = offsets[r]; i < offsets[r + 1]; ++i) {
        const float* other = in + items[i] * stride + b;
        const float w = weights[i];
        for (std::size_t f = 0; f < lanes; ++f) sum[f] += w * (other[f] - mine[f]);
      }
      float* to = out + r * stride + b;
      for (std::size_t f = 0; f < lanes; ++f) to[f] = mine[f] + sum[f];
    }
  }
}

/// Neighbour lists in row numbers; weights unset.
SurfaceFilter lists_of(const Topology& topology, const RowOrder& order) {
  SurfaceFilter filter;
  filter.offsets.push_back(0);
  for (const VertexIndex v : order.order) {
    for (const VertexIndex n : topology.neighbours_of(v)) filter.items.push_back(order.row_of[n]);
    filter.offsets.push_back(static_cast<uint32_t>(filter.items.size()));
  }
  filter.weights.assign(filter.items.size(), 0.0F);
  return filter;
}

}  // namespace

RowOrder breadth_first(const Topology& topology) {
  const std::size_t count = topology.vertex_count();
  RowOrder rows;
  rows.row_of.assign(count, invalid_index);
  rows.order.reserve(count);
  for (std::size_t start = 0; start < count; ++start) {
    if (rows.row_of[start] != invalid_index) continue;
    rows.row_of[start] = static_cast<uint32_t>(rows.order.size());
    rows.order.push_back(static_cast<VertexIndex>(start));
    for (std::size_t next = rows.order.size() - 1; next < rows.order.size(); ++next) {
      for (const VertexIndex n : topology.neighbours_of(rows.order[next])) {
        if (rows.row_of[n] != invalid_index) continue;
        rows.row_of[n] = static_cast<uint32_t>(rows.order.size());
        rows.order.push_back(n);
      }
    }
  }
  return rows;
}

SurfaceFilter ring_filter(const Topology& topology, const RowOrder& order,
                          std::span<const Eigen::Vector3d> rest) {
  SurfaceFilter filter = lists_of(topology, order);
  filter.step.assign(order.order.size(), 0.0F);
  for (std::size_t r = 0; r < order.order.size(); ++r) {
    const auto ring = topology.neighbours_of(order.order[r]);
    const float rate = 1.0F / static_cast<float>(ring.size() + 1);
    double sum = 0.0;
    for (const VertexIndex n : ring) sum += (rest[n] - rest[order.order[r]]).squaredNorm();
    for (uint32_t i = filter.offsets[r]; i < filter.offsets[r + 1]; ++i) filter.weights[i] = rate;
    filter.step[r] = 0.5F * rate * static_cast<float>(sum);  // two axes share the squared length
  }
  return filter;
}

double SpatialLevels::passes() const {
  double sum = 0.0;
  for (const LevelStep& step : steps) sum += step.passes;
  return sum;
}

FrameBlock::FrameBlock(const VertexCurves& scalar, const RowOrder& order, std::size_t first,
                       std::size_t frames, float offset)
    : rows_(order.order.size()),
      stride_((frames + lanes - 1) / lanes * lanes),
      current_(rows_ * stride_, 0.0F),
      next_(rows_ * stride_) {
  for (std::size_t r = 0; r < rows_; ++r) {
    const auto curve = scalar.of(order.order[r]).subspan(first, frames);
    std::transform(curve.begin(), curve.end(), current_.data() + r * stride_,
                   [offset](float d) { return d - offset; });
  }
}

void FrameBlock::smooth(const SurfaceFilter& filter, const LevelStep& step) {
  for (int pass = 0; pass < step.passes; ++pass) {
    if (step.factor) {
      step.factor->step(current_.data(), next_.data(), stride_);
      continue;
    }
    smooth_rows(current_.data(), next_.data(), stride_, filter.offsets.data(), filter.items.data(),
                filter.weights.data(), rows_);
    std::swap(current_, next_);
  }
}

namespace {

/// The rows of the tile and then their neighbours.
void choose_slots(TileLevels& tile, const SurfaceFilter& filter, std::size_t row_count) {
  tile.slot_of.assign(row_count, invalid_index);
  const auto add = [&](uint32_t row) {
    if (tile.slot_of[row] != invalid_index) return;
    tile.slot_of[row] = static_cast<uint32_t>(tile.rows.size());
    tile.rows.push_back(row);
  };
  for (std::size_t r = tile.begin; r < tile.end; ++r) add(static_cast<uint32_t>(r));
  for (std::size_t r = tile.begin; r < tile.end; ++r) {
    for (uint32_t i = filter.offsets[r]; i < filter.offsets[r + 1]; ++i) add(filter.items[i]);
  }
}

}  // namespace

TileLevels make_tile(const SpatialLevels& levels, const RowOrder& order, const VertexCurves& scalar,
                     std::size_t begin, std::size_t end, const RunContext& ctx) {
  TileLevels tile;
  tile.begin = begin;
  tile.end = end;
  tile.level_count = levels.steps.size();
  tile.frame_count = scalar.frame_count;
  choose_slots(tile, levels.filter, order.order.size());
  tile.values = Buffer<float>(tile.rows.size() * tile.level_count * tile.frame_count);
  parallel_chunks(ctx, scalar.frame_count, lanes, [&](std::size_t first, std::size_t last) {
    const FlushDenormals flush;
    FrameBlock block(scalar, order, first, last - first, levels.offset);
    for (std::size_t k = 0; k < tile.level_count; ++k) {
      ctx.check_cancelled();
      block.smooth(levels.filter, levels.steps[k]);
      for (std::size_t slot = 0; slot < tile.rows.size(); ++slot) {
        std::memcpy(tile.level(slot, k) + first, block.row(tile.rows[slot]),
                    (last - first) * sizeof(float));
      }
    }
  });
  return tile;
}

}  // namespace kinemesh::scale_space
