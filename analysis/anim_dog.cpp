#include "analysis/anim_dog.h"

#include <algorithm>
#include <cmath>

#include "analysis/dog_rows.h"
#include "analysis/flush_denormals.h"
#include "analysis/scale_space.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using scale_space::SpatialLevels;
using scale_space::TileLevels;

constexpr std::size_t smoothing_grain = 64;

/// A minimum in scale, time and space.
struct Extremum {
  VertexIndex vertex;
  uint32_t k, l, frame;
  float response;  // −D
};

struct Detector {
  const AnimatedMesh& animation;
  const DeformationResult& rest;
  const VertexCurves& scalar;
  const DetectOptions& options;
  const RunContext& ctx;
  scale_space::RowOrder order;
  SpatialLevels space;
  dog::Scales scales;
  std::vector<double> time_variances;  // frames², of the levels
};

/// Half the largest change of an axis of the bounding box: the radius of the largest blob (4.6.1).
double largest_radius(const AnimatedMesh& animation) {
  Eigen::Vector3f first = Eigen::Vector3f::Zero();
  float change = 0.0F;
  for (std::size_t f = 0; f < animation.frame_count(); ++f) {
    const auto frame = animation.frame(f);
    const Eigen::Vector3f size =
        (frame.colwise().maxCoeff() - frame.colwise().minCoeff()).transpose();
    if (f == 0) first = size;
    change = std::max(change, (size - first).cwiseAbs().maxCoeff());
  }
  return 0.5 * change;
}

/// A level for each ring average, and the variance it reaches at every row (4-9, measured).
void ring_levels(Detector& d) {
  SpatialLevels& s = d.space;
  s.filter = ring_filter(d.animation.topology(), d.order, d.rest.rest);
  double mean = 0.0;
  for (const float v : s.filter.step) mean += v;
  mean /= static_cast<double>(std::max<std::size_t>(s.filter.step.size(), 1));
  std::size_t count = static_cast<std::size_t>(d.options.smoothings);
  if (count == 0 && mean > 0.0) {
    const double radius = largest_radius(d.animation);
    count =
        static_cast<std::size_t>(std::clamp(std::ceil(0.5 * radius * radius / mean), 3.0, 150.0));
  }
  count = std::max<std::size_t>(count, 3);
  const std::size_t rows = d.order.order.size();
  std::vector<float> variance(rows, 0.0F), next(rows);
  s.local_variances.assign(rows * (count + 1), 0.0F);
  for (std::size_t k = 0; k <= count; ++k) {
    double sum = 0.0;
    for (std::size_t r = 0; r < rows; ++r) {
      s.local_variances[r * (count + 1) + k] = variance[r];
      sum += variance[r];
      next[r] = variance[r] + s.filter.step[r];
      for (uint32_t i = s.filter.offsets[r]; i < s.filter.offsets[r + 1]; ++i) {
        next[r] += s.filter.weights[i] * (variance[s.filter.items[i]] - variance[r]);
      }
    }
    s.variances.push_back(sum / static_cast<double>(std::max<std::size_t>(rows, 1)));
    s.steps.push_back({k == 0 ? 0 : 1});
    std::swap(variance, next);
  }
}

/// Levels of the cotangent diffusion: variance 2 t after time t, in two implicit steps a level.
void cotangent_levels(Detector& d) {
  constexpr int passes = 2;
  SpatialLevels& s = d.space;
  s.filter = ring_filter(d.animation.topology(), d.order, d.rest.rest);  // for its lists
  diffusion::Operator diffusion(d.animation.topology(), d.rest.rest, d.order.row_of);
  double reached = 0.0;
  for (int k = 0; k <= d.options.sigma_levels; ++k) {
    const double sigma = d.options.sigma * d.rest.root_area_mm * std::pow(d.options.step, k);
    const double time = 0.5 * (sigma * sigma - reached);
    reached = sigma * sigma;
    s.variances.push_back(reached);
    s.steps.push_back({passes, diffusion.factor(time / passes)});
  }
}

/// Passes of (a, 1 − 2a, a) with a ≤ 1/4 that add this variance in frames².
dog::TimeStep time_step(double variance) {
  dog::TimeStep step;
  step.passes = std::max(1, static_cast<int>(std::ceil(variance / 0.5 - 1e-9)));
  step.a = static_cast<float>(0.5 * variance / step.passes);
  return step;
}

void temporal_levels(Detector& d) {
  dog::Scales& s = d.scales;
  if (d.options.filter == SpatialFilter::ring) {
    s.tau_levels = static_cast<std::size_t>(std::max(d.options.time_smoothings, 3));
    s.first.passes = 0;
    for (std::size_t l = 0; l <= s.tau_levels; ++l) {
      d.time_variances.push_back(static_cast<double>(l) * 2.0 / 3.0);
    }
    s.steps.assign(s.tau_levels, {1, 1.0F / 3.0F});
    return;
  }
  s.tau_levels = static_cast<std::size_t>(d.options.tau_levels);
  const double first = d.options.tau * static_cast<double>(d.animation.frame_count());
  for (std::size_t l = 0; l <= s.tau_levels; ++l) {
    const double tau = first * std::pow(d.options.step, static_cast<double>(l));
    d.time_variances.push_back(tau * tau);
    if (l > 0) s.steps.push_back(time_step(tau * tau - d.time_variances[l - 1]));
  }
  s.first = time_step(first * first);
}

void set_coefficients(Detector& d) {
  dog::Scales& s = d.scales;
  const bool thesis = d.options.norm == ScaleNorm::thesis;
  // Units of σ and τ: edges and frames, or the first level of each.
  const auto first_of = [](const std::vector<double>& v) {
    return v[0] > 0.0 ? v[0] : std::max(v[1], 1e-300);
  };
  const double unit =
      thesis ? d.rest.mean_edge_mm * d.rest.mean_edge_mm : first_of(d.space.variances);
  const double time_unit = thesis ? 1.0 : first_of(d.time_variances);
  for (std::size_t k = 0; k < s.sigma_levels; ++k) {
    for (std::size_t l = 0; l < s.tau_levels; ++l) {
      const double var = d.space.variances[k] / unit, tau_var = d.time_variances[l] / time_unit;
      const double var_step = (d.space.variances[k + 1] / unit) - var;
      const double tau_step = (d.time_variances[l + 1] / time_unit) - tau_var;
      const double a = var * std::pow(tau_var, 0.25), b = std::sqrt(var) * std::pow(tau_var, 0.75);
      s.space.push_back(static_cast<float>(thesis ? a : a / var_step));
      s.time.push_back(static_cast<float>(thesis ? b : b / tau_step));
    }
  }
}

void prepare(Detector& d) {
  d.order = scale_space::breadth_first(d.animation.topology());
  if (d.options.filter == SpatialFilter::ring) {
    ring_levels(d);
  } else {
    cotangent_levels(d);
  }
  d.scales.sigma_levels = d.space.steps.size() - 1;
  temporal_levels(d);
  set_coefficients(d);
  d.scales.ends = d.options.end_scales;
  const auto [low, high] = std::minmax_element(d.scalar.values.begin(), d.scalar.values.end());
  d.space.offset = *low;
  d.scales.limit =
      -1e-6F * (*high - *low) * *std::max_element(d.scales.space.begin(), d.scales.space.end());
}

/// Whether D at the tile's row is below that of all its neighbours in this frame and the next ones.
bool lowest_around(const Detector& d, const TileLevels& tile, const dog::TimeKernels& kernels,
                   std::size_t slot, const dog::Hit& hit, float& response) {
  const auto at = [&](std::size_t other, std::size_t frame) {
    return kernels.response(d.scales, hit.k, hit.l, frame, tile.level(other, hit.k),
                            tile.level(other, hit.k + 1));
  };
  const float here = at(slot, hit.frame);
  if (!(here < d.scales.limit)) return false;
  const uint32_t row = tile.rows[slot];
  const uint32_t *first = d.space.filter.items.data() + d.space.filter.offsets[row],
                 *last = d.space.filter.items.data() + d.space.filter.offsets[row + 1];
  if (first == last) return false;
  const std::size_t low = hit.frame > 0 ? hit.frame - 1 : 0;
  const std::size_t high = std::min<std::size_t>(hit.frame + 1, tile.frame_count - 1);
  for (const std::size_t frame : {static_cast<std::size_t>(hit.frame), low, high}) {
    for (const uint32_t* n = first; n != last; ++n) {
      const float there = at(tile.slot_of[*n], frame);
      // Of neighbours that rounding makes equal the first counts: on a symmetric mesh the lowest
      // place may lie just between two vertices.
      const bool tie = there == here && frame == hit.frame && *n > row;
      if (!(there > here) && !tie) return false;
    }
  }
  response = -here;
  return true;
}

void test_tile(const Detector& d, const TileLevels& tile, const dog::TimeKernels& kernels,
               std::vector<Extremum>& extrema) {
  const std::size_t count = tile.end - tile.begin;
  std::vector<std::vector<Extremum>> parts((count + smoothing_grain - 1) / smoothing_grain);
  parallel_chunks(d.ctx, count, smoothing_grain, [&](std::size_t begin, std::size_t end) {
    const FlushDenormals flush;
    dog::RowTester tester(d.scales, tile.frame_count);
    std::vector<dog::Hit> hits;
    for (std::size_t slot = begin; slot < end; ++slot) {
      hits.clear();
      tester.test(tile.level(slot, 0), hits);
      for (const dog::Hit& hit : hits) {
        float response = 0.0F;
        if (!lowest_around(d, tile, kernels, slot, hit, response)) continue;
        parts[begin / smoothing_grain].push_back(
            {d.order.order[tile.begin + slot], hit.k, hit.l, hit.frame, response});
      }
    }
  });
  for (const auto& part : parts) extrema.insert(extrema.end(), part.begin(), part.end());
}

/// Rows per tile whose levels fit the memory; their neighbours come on top.
std::size_t tile_rows(const Detector& d) {
  const double row_bytes = static_cast<double>(d.space.steps.size()) *
                           static_cast<double>(d.scalar.frame_count) * sizeof(float);
  const double fitting = d.options.memory_mb * 1e6 / std::max(row_bytes, 1.0);
  const std::size_t rows = d.order.order.size();
  if (fitting >= static_cast<double>(rows)) return std::max<std::size_t>(rows, 1);
  return std::max<std::size_t>(static_cast<std::size_t>(0.8 * fitting), 64);
}

std::vector<Extremum> find_extrema(const Detector& d, DetectResult& result) {
  const dog::TimeKernels kernels(d.scales, d.scalar.frame_count);
  std::vector<Extremum> extrema;
  const std::size_t rows = d.order.order.size(), step = tile_rows(d);
  for (std::size_t begin = 0; begin < rows; begin += step) {
    d.ctx.progress(static_cast<double>(begin) / static_cast<double>(rows));
    const TileLevels tile =
        make_tile(d.space, d.order, d.scalar, begin, std::min(rows, begin + step), d.ctx);
    result.level_bytes = std::max(result.level_bytes, tile.values.size() * sizeof(float));
    ++result.tiles;
    test_tile(d, tile, kernels, extrema);
  }
  d.ctx.progress(1.0);
  // The strongest first; ties by place, so that the order does not depend on tiles.
  std::sort(extrema.begin(), extrema.end(), [](const Extremum& a, const Extremum& b) {
    if (a.response != b.response) return a.response > b.response;
    return std::tie(a.vertex, a.frame, a.k, a.l) < std::tie(b.vertex, b.frame, b.k, b.l);
  });
  return extrema;
}

bool near_stronger(const Detector& d, const std::vector<Extremum>& kept, const Extremum& e) {
  const double apart = d.options.apart * d.rest.diagonal_mm;
  const double apart_time = d.options.apart_time * static_cast<double>(d.scalar.frame_count);
  return std::any_of(kept.begin(), kept.end(), [&](const Extremum& other) {
    const double frames = std::abs(static_cast<double>(other.frame) - e.frame);
    return frames <= apart_time &&
           (d.rest.rest[other.vertex] - d.rest.rest[e.vertex]).norm() <= apart;
  });
}

std::vector<Extremum> choose(const Detector& d, const std::vector<Extremum>& extrema) {
  std::vector<Extremum> kept;
  const bool separate = d.options.apart > 0.0 && d.options.apart_time > 0.0;
  for (const Extremum& e : extrema) {
    if (d.options.strongest > 0 && kept.size() >= static_cast<std::size_t>(d.options.strongest))
      break;
    if (e.response < d.options.threshold * extrema.front().response) break;
    if (!separate || !near_stronger(d, kept, e)) kept.push_back(e);
  }
  return kept;
}

Feature feature_of(const Detector& d, const Extremum& e) {
  Feature f;
  f.vertex = e.vertex;
  f.frame = e.frame;
  f.time_s = d.animation.time_s(e.frame);
  double variance = d.space.variances[e.k];
  if (!d.space.local_variances.empty()) {
    variance = d.space.local_variances[d.order.row_of[e.vertex] * d.space.steps.size() + e.k];
  }
  f.sigma_mm = std::sqrt(variance);
  f.tau_s = std::sqrt(d.time_variances[e.l]);
  if (d.animation.rate_hz > 0) f.tau_s /= d.animation.rate_hz;
  f.response = e.response;
  return f;
}

void describe(const Detector& d, DetectResult& result) {
  result.set.vertex_count = d.animation.vertex_count();
  result.set.frame_count = d.animation.frame_count();
  result.set.rate_hz = d.animation.rate_hz;
  result.set.diagonal_mm = d.rest.diagonal_mm;
  for (const double v : d.space.variances) result.sigmas_mm.push_back(std::sqrt(v));
  const double rate = d.animation.rate_hz > 0 ? d.animation.rate_hz : 1.0;
  for (const double v : d.time_variances) result.taus_s.push_back(std::sqrt(v) / rate);
  result.samples = d.scales.sigma_levels * d.scales.tau_levels * d.scalar.values.size();
  result.spatial_passes = d.space.passes() * static_cast<double>(result.tiles);
}

}  // namespace

DetectResult detect_in_scalar(const AnimatedMesh& animation, const DeformationResult& rest,
                              const VertexCurves& scalar, const DetectOptions& options,
                              const RunContext& ctx) {
  options.validate();
  if (scalar.vertex_count != animation.vertex_count() ||
      scalar.frame_count != animation.frame_count() || rest.rest.size() != scalar.vertex_count) {
    throw UsageError({.what = "the deformation is not that of this animation"});
  }
  DetectResult result;
  Detector d{animation, rest, scalar, options, ctx, {}, {}, {}, {}};
  if (animation.frame_count() < 3) {
    describe(d, result);
    result.empty_reason = "an animation of " + count_of(animation.frame_count(), "frame") +
                          " has no moment that stands out: at least 3 are needed";
    return result;
  }
  prepare(d);
  std::vector<Extremum> extrema;
  if (d.scales.limit < 0.0F) extrema = find_extrema(d, result);
  result.extrema = extrema.size();
  describe(d, result);
  for (const Extremum& e : choose(d, extrema)) result.set.features.push_back(feature_of(d, e));
  if (result.set.features.empty()) {
    result.empty_reason = d.scales.limit < 0.0F
                              ? "deformation has no extremum over space, time and scale"
                              : "nothing deforms: strain and curvature are the same in all frames";
  }
  return result;
}

DetectResult detect_features(const AnimatedMesh& animation, const DeformationResult& deformation,
                             const DetectOptions& options, const RunContext& ctx) {
  return detect_in_scalar(animation, deformation, deformation.values, options, ctx);
}

}  // namespace kinemesh
