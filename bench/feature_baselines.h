// What others find, for comparison in the same run: MeshDoG (Zaharescu et al. 2009) on the same
// deformation, frame by frame, and the velocity saliency of Bulbul et al. 2010.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/anim_dog.h"
#include "analysis/scale_space.h"

namespace kinemesh::bench {

/// The strongest `count` candidates at least `apart` of diagonal and duration from each other.
inline std::vector<Feature> strongest_apart(std::vector<Feature> all, const DeformationResult& rest,
                                            std::size_t frames, std::size_t count, double apart) {
  std::stable_sort(all.begin(), all.end(),
                   [](const Feature& a, const Feature& b) { return a.response > b.response; });
  std::vector<Feature> kept;
  for (const Feature& f : all) {
    if (kept.size() == count) break;
    const bool near = std::any_of(kept.begin(), kept.end(), [&](const Feature& g) {
      return (rest.rest[f.vertex] - rest.rest[g.vertex]).norm() <= apart * rest.diagonal_mm &&
             std::abs(static_cast<double>(f.frame) - g.frame) <=
                 apart * static_cast<double>(frames);
    });
    if (apart <= 0.0 || !near) kept.push_back(f);
  }
  return kept;
}

/// A scalar smoothed to each σ (mm), all frames: [level][vertex × frames].
inline std::vector<VertexCurves> smoothed(const Topology& topology, const DeformationResult& rest,
                                          const VertexCurves& scalar,
                                          const std::vector<double>& sigmas) {
  const auto order = scale_space::breadth_first(topology);
  diffusion::Operator diffusion(topology, rest.rest, order.row_of);
  const auto filter = scale_space::ring_filter(topology, order, rest.rest);
  std::vector<scale_space::LevelStep> steps;
  double reached = 0.0;
  for (const double sigma : sigmas) {
    steps.push_back({2, diffusion.factor(0.25 * (sigma * sigma - reached))});
    reached = sigma * sigma;
  }
  std::vector<VertexCurves> levels(sigmas.size(),
                                   VertexCurves(scalar.vertex_count, scalar.frame_count));
  constexpr std::size_t lanes = scale_space::FrameBlock::lanes;
  for (std::size_t first = 0; first < scalar.frame_count; first += lanes) {
    const std::size_t frames = std::min(lanes, scalar.frame_count - first);
    scale_space::FrameBlock block(scalar, order, first, frames);
    for (std::size_t k = 0; k < steps.size(); ++k) {
      block.smooth(filter, steps[k]);
      for (std::size_t r = 0; r < order.order.size(); ++r) {
        std::copy_n(block.row(r), frames, levels[k].of(order.order[r]).data() + first);
      }
    }
  }
  return levels;
}

/// Extrema of the spatial DoG over 1-ring and neighbouring scales in each frame; its strongest 5 %
/// go on (the paper's threshold), ranked by |DoG|. `octave`: σ of the first level in mean edges.
inline std::vector<Feature> mesh_dog(const AnimatedMesh& mesh, const DeformationResult& d,
                                     std::size_t count, double octave, double apart) {
  std::vector<double> sigmas;
  for (int k = 0; k < 8; ++k) sigmas.push_back(octave * d.mean_edge_mm * std::pow(2.0, k / 3.0));
  const auto levels = smoothed(mesh.topology(), d, d.values, sigmas);
  const auto dog = [&](std::size_t k, std::size_t v, std::size_t f) {
    return levels[k + 1].of(v)[f] - levels[k].of(v)[f];
  };
  std::vector<Feature> all;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const auto ring = mesh.topology().neighbours_of(static_cast<VertexIndex>(v));
    for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
      for (std::size_t k = 1; k + 2 < sigmas.size(); ++k) {
        const float here = dog(k, v, f), sign = here < 0 ? -1.0F : 1.0F;
        bool most = std::abs(here) > 1e-7F;
        for (std::size_t j = k - 1; most && j <= k + 1; ++j) {
          most = j == k || sign * here > sign * dog(j, v, f);
          for (std::size_t i = 0; most && i < ring.size(); ++i) {
            most = sign * here > sign * dog(j, ring[i], f);
          }
        }
        if (!most) continue;
        Feature feature{.vertex = static_cast<VertexIndex>(v), .frame = static_cast<uint32_t>(f)};
        feature.response = std::abs(here);
        feature.sigma_mm = sigmas[k];
        all.push_back(feature);
      }
    }
  }
  return strongest_apart(std::move(all), d, mesh.frame_count(), count, apart);
}

/// Local maxima over the 1-ring in each frame of the saliency of speed: differences of Gaussian
/// averages at σ and 2 σ, summed over σ = 2…6 ε, ε = 0.3 % of the diagonal times `wider`.
inline std::vector<Feature> velocity_saliency(const AnimatedMesh& mesh, const DeformationResult& d,
                                              std::size_t count, double wider, double apart) {
  VertexCurves speed(mesh.vertex_count(), mesh.frame_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
      const std::size_t g = std::min(f + 1, mesh.frame_count() - 1);
      const auto vertex = static_cast<VertexIndex>(v);
      speed.of(v)[f] =
          (mesh.position(g, vertex) - mesh.position(g > 0 ? g - 1 : 0, vertex)).norm() /
          static_cast<float>(d.diagonal_mm);
    }
  }
  const double epsilon = 0.003 * d.diagonal_mm * wider;
  std::vector<double> sigmas;
  for (const double s : {2, 3, 4, 5, 6, 8, 10, 12}) sigmas.push_back(s * epsilon);
  const auto levels = smoothed(mesh.topology(), d, speed, sigmas);
  VertexCurves saliency(mesh.vertex_count(), mesh.frame_count());
  const std::array<std::array<std::size_t, 2>, 5> pairs{{{0, 2}, {1, 4}, {2, 5}, {3, 6}, {4, 7}}};
  for (std::size_t i = 0; i < saliency.values.size(); ++i) {
    float sum = 0;
    for (const auto& [a, b] : pairs) sum += std::abs(levels[a].values[i] - levels[b].values[i]);
    saliency.values[i] = sum;
  }
  std::vector<Feature> all;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const auto ring = mesh.topology().neighbours_of(static_cast<VertexIndex>(v));
    for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
      const float here = saliency.of(v)[f];
      const bool most = here > 0 && std::all_of(ring.begin(), ring.end(), [&](VertexIndex n) {
                          return here > saliency.of(n)[f];
                        });
      if (!most) continue;
      Feature feature{.vertex = static_cast<VertexIndex>(v), .frame = static_cast<uint32_t>(f)};
      feature.response = here;
      all.push_back(feature);
    }
  }
  return strongest_apart(std::move(all), d, mesh.frame_count(), count, apart);
}

}  // namespace kinemesh::bench
