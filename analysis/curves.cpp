// Displacement and deformation curves, their distance, and displacement features.
#include <algorithm>
#include <cmath>

#include "analysis/descriptors.h"

namespace kinemesh {
namespace {

constexpr std::size_t curve_samples = 64;

/// Second derivatives of the natural cubic spline through equidistant values.
std::vector<double> spline_bends(std::span<const float> y) {
  const std::size_t n = y.size();
  std::vector<double> bend(n, 0.0), ratio(n, 0.0);
  if (n < 3) return bend;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double right = 6.0 * (static_cast<double>(y[i + 1]) - 2.0 * y[i] + y[i - 1]);
    const double pivot = 4.0 - ratio[i - 1];
    ratio[i] = 1.0 / pivot;
    bend[i] = (right - bend[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i >= 1; --i) bend[i] -= ratio[i] * bend[i + 1];
  return bend;
}

std::array<double, curve_samples> resample(std::span<const float> y) {
  std::array<double, curve_samples> samples{};
  const std::vector<double> bend = spline_bends(y);
  for (std::size_t s = 0; s < curve_samples; ++s) {
    const double x = static_cast<double>(s) * static_cast<double>(y.size() - 1) /
                     static_cast<double>(curve_samples - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(x), y.size() - 1);
    const double t = x - static_cast<double>(i), u = 1.0 - t;
    if (i + 1 == y.size()) {
      samples[s] = y[i];
      continue;
    }
    samples[s] =
        u * y[i] + t * y[i + 1] + ((u * u * u - u) * bend[i] + (t * t * t - t) * bend[i + 1]) / 6.0;
  }
  return samples;
}

/// Length of the step of a vertex from frame f to the next, mm.
float step_length(const AnimatedMesh& animation, std::size_t f, VertexIndex v) {
  return (animation.position(f + 1, v) - animation.position(f, v)).norm();
}

float longest_step(const AnimatedMesh& animation) {
  float longest = 0.0F;
  for (std::size_t f = 0; f + 1 < animation.frame_count(); ++f) {
    const auto a = animation.frame(f), b = animation.frame(f + 1);
    longest = std::max(longest, (b - a).rowwise().squaredNorm().maxCoeff());
  }
  return std::sqrt(longest);
}

}  // namespace

double curve_distance(std::span<const float> a, std::span<const float> b) {
  if (a.empty() || b.empty()) return 0.0;
  const auto x = resample(a), y = resample(b);
  double sum = 0.0;
  for (std::size_t s = 0; s < curve_samples; ++s) sum += (x[s] - y[s]) * (x[s] - y[s]);
  return std::sqrt(sum / static_cast<double>(curve_samples));
}

/// Fills in both curves of all features.
void describe_by_curves(FeatureSet& set, const AnimatedMesh& animation,
                        const DeformationResult& deformation) {
  const float longest = longest_step(animation);
  for (Feature& f : set.features) {
    auto& moved = f.descriptor.displacement;
    moved.clear();
    for (std::size_t frame = 0; frame + 1 < animation.frame_count(); ++frame) {
      const float step = step_length(animation, frame, f.vertex);
      moved.push_back(longest > 0.0F ? step / longest : 0.0F);
    }
    f.descriptor.deformation.clear();
    for (const float d : deformation.values.of(f.vertex)) {
      f.descriptor.deformation.push_back(deformation.largest > 0.0F ? d / deformation.largest
                                                                    : 0.0F);
    }
  }
}

void DisplacementOptions::declare(ParameterSet& p) {
  p.group("displacement", "Displacement features");
  p.number("least-path", least_path,
           {.min = 0.0,
            .max = 1.0,
            .help = "Least length of a vertex' path, as a part of the longest of all"});
  p.number("path-apart", path_apart,
           {.min = 0.0,
            .max = 1.0,
            .help = "Within this part of the diagonal only the longest path counts"});
}

std::vector<Feature> displacement_features(const AnimatedMesh& animation,
                                           const DeformationResult& rest,
                                           const DisplacementOptions& options) {
  options.validate();
  const std::size_t count = animation.vertex_count();
  std::vector<double> path(count, 0.0);
  double longest = 0.0;
  for (std::size_t v = 0; v < count; ++v) {
    const auto vertex = static_cast<VertexIndex>(v);
    for (std::size_t f = 0; f + 1 < animation.frame_count(); ++f) {
      path[v] += step_length(animation, f, vertex);
    }
    if (!animation.topology().faces_of(vertex).empty()) longest = std::max(longest, path[v]);
  }
  std::vector<VertexIndex> maxima;
  for (std::size_t v = 0; v < count && longest > 0.0; ++v) {
    const auto ring = animation.topology().neighbours_of(static_cast<VertexIndex>(v));
    const bool highest =
        std::all_of(ring.begin(), ring.end(), [&](VertexIndex n) { return path[v] > path[n]; });
    if (!ring.empty() && highest && path[v] > options.least_path * longest) {
      maxima.push_back(static_cast<VertexIndex>(v));
    }
  }
  std::stable_sort(maxima.begin(), maxima.end(),
                   [&](VertexIndex a, VertexIndex b) { return path[a] > path[b]; });
  std::vector<Feature> features;
  for (const VertexIndex v : maxima) {
    const bool covered = std::any_of(features.begin(), features.end(), [&](const Feature& f) {
      return (rest.rest[f.vertex] - rest.rest[v]).norm() < options.path_apart * rest.diagonal_mm;
    });
    if (covered) continue;
    Feature f{.vertex = v, .kind = FeatureKind::displacement};
    f.response = path[v] / longest;
    for (std::size_t frame = 0; frame + 1 < animation.frame_count(); ++frame) {
      if (step_length(animation, frame, v) > step_length(animation, f.frame, v)) {
        f.frame = static_cast<uint32_t>(frame);
      }
    }
    f.time_s = animation.time_s(f.frame);
    features.push_back(std::move(f));
  }
  return features;
}

}  // namespace kinemesh
