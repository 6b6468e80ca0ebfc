#include "reconstruct/spread_product.h"

#include <algorithm>

#include "config/multiversion.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

constexpr std::size_t vertex_group = 4;    // vertices
constexpr std::size_t frames_at_once = 8;  // 24 columns
constexpr std::size_t panel_columns = 3 * frames_at_once;
constexpr std::size_t groups_per_chunk = 32;  // 80 KB of weights for 160 markers

/// out (vertex_group × panel_columns) = weights (markers × vertex_group)ᵀ · panel (markers ×
/// panel_columns).
KINEMESH_MULTIVERSION void tile(const float* __restrict weights, const float* __restrict panel,
                                std::size_t markers, float* __restrict out) {
  float sums[vertex_group][panel_columns] = {};
  for (std::size_t m = 0; m < markers; ++m) {
    for (std::size_t r = 0; r < vertex_group; ++r) {
      for (std::size_t c = 0; c < panel_columns; ++c) {
        sums[r][c] += weights[m * vertex_group + r] * panel[m * panel_columns + c];
      }
    }
  }
  for (std::size_t r = 0; r < vertex_group; ++r) {
    for (std::size_t c = 0; c < panel_columns; ++c) out[r * panel_columns + c] = sums[r][c];
  }
}

/// Displacements in panels of `frames_at_once` frames: panels × markers × panel_columns, zeros at
/// the end.
std::vector<float> panels_of(const Eigen::MatrixXf& displacements, std::size_t frames) {
  const auto markers = static_cast<std::size_t>(displacements.rows());
  const std::size_t panels = (frames + frames_at_once - 1) / frames_at_once;
  std::vector<float> packed(panels * markers * panel_columns, 0.0F);
  for (std::size_t c = 0; c < 3 * frames; ++c) {
    float* to = packed.data() + c / panel_columns * markers * panel_columns + c % panel_columns;
    for (std::size_t m = 0; m < markers; ++m) {
      to[m * panel_columns] =
          displacements(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(c));
    }
  }
  return packed;
}

}  // namespace

PackedSpread::PackedSpread(const Eigen::MatrixXf& spread)
    : vertices_(static_cast<std::size_t>(spread.rows())),
      markers_(static_cast<std::size_t>(spread.cols())),
      packed_((vertices_ + vertex_group - 1) / vertex_group * markers_ * vertex_group, 0.0F) {
  for (std::size_t v = 0; v < vertices_; ++v) {
    float* to = packed_.data() + v / vertex_group * markers_ * vertex_group + v % vertex_group;
    for (std::size_t m = 0; m < markers_; ++m) {
      to[m * vertex_group] = spread(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(m));
    }
  }
}

void PackedSpread::apply(std::span<const float> rest, const Eigen::MatrixXf& displacements,
                         std::span<float> out, const RunContext& ctx) const {
  const auto frames = static_cast<std::size_t>(displacements.cols() / 3);
  const std::vector<float> panels = panels_of(displacements, frames);
  const std::size_t groups = (vertices_ + vertex_group - 1) / vertex_group;
  const auto one_tile = [&](std::size_t g, std::size_t first_frame) {
    float sums[vertex_group * panel_columns];
    tile(packed_.data() + g * markers_ * vertex_group,
         panels.data() + first_frame / frames_at_once * markers_ * panel_columns, markers_, sums);
    const std::size_t last_row = std::min(vertex_group, vertices_ - g * vertex_group);
    const std::size_t last_frame = std::min(frames_at_once, frames - first_frame);
    for (std::size_t f = 0; f < last_frame; ++f) {
      float* to = out.data() + 3 * ((first_frame + f) * vertices_ + g * vertex_group);
      const float* from = rest.data() + 3 * g * vertex_group;
      for (std::size_t r = 0; r < last_row; ++r) {
        for (std::size_t k = 0; k < 3; ++k) {
          to[3 * r + k] = from[3 * r + k] + sums[r * panel_columns + 3 * f + k];
        }
      }
    }
  };
  parallel_chunks(ctx, groups, groups_per_chunk, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = 0; f < frames; f += frames_at_once) {
      for (std::size_t g = begin; g < end; ++g) one_tile(g, f);
    }
  });
}

}  // namespace kinemesh
