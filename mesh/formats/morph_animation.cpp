#include "mesh/formats/morph_animation.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>

#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"
#include "mesh/pca/pca.h"

namespace kinemesh {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::array<std::size_t, 12> key_steps{1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24};
/// Below this root mean square error more modes only make the file larger.
constexpr double negligible_mm = 0.001;

/// A number of modes at a key step, and what it costs.
struct Choice {
  std::size_t modes = 0, step = 1, bytes = 0;
  double rms_mm = 0.0;
};

class MorphFitter {
 public:
  MorphFitter(const AnimatedMesh& mesh, const GltfOptions& options, const MorphCost& cost,
              const RunContext& ctx)
      : mesh_(mesh), options_(options), cost_(cost), ctx_(ctx) {}

  MorphAnimation fit() {
    const std::size_t most = most_modes();
    for (std::size_t modes = std::min<std::size_t>(64, most);; modes = std::min(2 * modes, most)) {
      decompose(modes);
      const bool all = modes == most || pca_.mode_count() < modes;
      if (options_.max_error_mm > 0) {
        if (const auto found = smallest_within_error()) return *found;
        if (!all) continue;
        MorphAnimation best = measured({pca_.mode_count(), 1});
        throw NoResultError(
            {.what = "the error of " + format_number(options_.max_error_mm) +
                     " mm cannot be kept: all modes leave " + format_number(best.max_error_mm) +
                     " mm",
             .remedy = "Ask for a larger --max-error, or for a format that keeps every float"});
      }
      const Choice best = best_within_budget();
      if (all || best.modes < modes || best.rms_mm <= negligible_mm) return measured(best);
    }
  }

 private:
  std::size_t bytes_of(std::size_t modes, std::size_t keys) const {
    return cost_.fixed + keys * sizeof(float) * (1 + modes) +
           modes * (cost_.per_target + 12 * mesh_.vertex_count());
  }

  std::size_t budget() const { return static_cast<std::size_t>(options_.budget_mb * 1e6); }

  /// Modes that fit into the budget at the lowest key rate; all there are when an error is asked.
  std::size_t most_modes() const {
    const std::size_t all = std::min(mesh_.frame_count() - 1, 3 * mesh_.vertex_count());
    if (options_.max_error_mm > 0) return all;
    const std::size_t keys = key_frames(mesh_.frame_count(), key_steps.back()).size();
    if (bytes_of(0, keys) > budget()) {
      throw NoResultError({.what = "the mesh alone takes " +
                                   format_fixed(static_cast<double>(bytes_of(0, keys)) / 1e6, 2) +
                                   " MB, more than the budget of " +
                                   format_number(options_.budget_mb) + " MB",
                           .remedy = "Give a larger --budget"});
    }
    return std::min(all, modes_within(keys));
  }

  std::size_t modes_within(std::size_t keys) const {
    const std::size_t still = bytes_of(0, keys);
    return still > budget() ? 0 : (budget() - still) / (bytes_of(1, keys) - still);
  }

  void decompose(std::size_t modes) {
    pca_ = pca_of(mesh_, {.modes = static_cast<int>(std::max<std::size_t>(modes, 1))}, ctx_);
    if (modes == 0) pca_.modes.resize(Eigen::NoChange, 0);
    spline_errors_.clear();
    for (const std::size_t step : key_steps) spline_errors_.push_back(spline_error(step));
  }

  std::vector<double> score(std::size_t mode) const {
    const auto column = pca_.scores.col(static_cast<Eigen::Index>(mode));
    return {column.begin(), column.end()};
  }

  /// Per mode: mean square distance of its scores from their spline.
  std::vector<double> spline_error(std::size_t step) const {
    const std::vector<std::size_t> keys = key_frames(mesh_.frame_count(), step);
    std::vector<double> errors(pca_.mode_count(), 0.0);
    if (step == 1) return errors;
    parallel_for(ctx_, errors.size(), 4, [&](std::size_t k) {
      const std::vector<double> values = score(k);
      const std::vector<double> fit = fit_linear_spline(values, keys);
      double sum = 0;
      for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        const double span = static_cast<double>(keys[i + 1] - keys[i]);
        for (std::size_t f = keys[i]; f < keys[i + 1]; ++f) {
          const double t = static_cast<double>(f - keys[i]) / span;
          const double d = values[f] - (fit[i] + t * (fit[i + 1] - fit[i]));
          sum += d * d;
        }
      }
      errors[k] = sum / static_cast<double>(values.size());
    });
    return errors;
  }

  /// Root mean square error by Pythagoras: modes left out, and splines of those kept.
  double rms(std::size_t modes, std::size_t step_index) const {
    const double left_out = pca_.rms_error_mm(modes);
    double splines = 0;
    for (std::size_t k = 0; k < modes; ++k) splines += spline_errors_[step_index][k];
    return std::sqrt(left_out * left_out + splines / static_cast<double>(mesh_.vertex_count()));
  }

  Choice best_within_budget() const {
    std::optional<Choice> best, good;
    for (std::size_t s = 0; s < key_steps.size(); ++s) {
      const std::size_t keys = key_frames(mesh_.frame_count(), key_steps[s]).size();
      if (bytes_of(0, keys) > budget()) continue;
      const std::size_t most = std::min(pca_.mode_count(), modes_within(keys));
      const double least = rms(most, s);
      if (!best || least < best->rms_mm) best = {most, key_steps[s], bytes_of(most, keys), least};
      if (least > negligible_mm) continue;
      std::size_t modes = most;
      while (modes > 0 && rms(modes - 1, s) <= negligible_mm) --modes;
      const Choice enough{modes, key_steps[s], bytes_of(modes, keys), rms(modes, s)};
      if (!good || enough.bytes < good->bytes) good = enough;
    }
    return good ? *good : *best;
  }

  /// The smallest choice whose measured error is small enough; nothing when none is.
  std::optional<MorphAnimation> smallest_within_error() const {
    std::optional<Choice> best;
    for (std::size_t s = 0; s < key_steps.size(); ++s) {
      ctx_.check_cancelled();
      const std::size_t keys = key_frames(mesh_.frame_count(), key_steps[s]).size();
      std::size_t low = 0, high = pca_.mode_count();
      while (low <= high && rms(low, s) > options_.max_error_mm) {
        if (++low > high) break;
      }
      if (low > high) continue;
      if (best && bytes_of(low, keys) >= best->bytes) continue;
      if (!holds({high, key_steps[s]})) {
        if (s == 0) return std::nullopt;
        break;  // splines at lower rates are worse still
      }
      while (low < high) {
        const std::size_t middle = (low + high) / 2;
        if (holds({middle, key_steps[s]})) {
          high = middle;
        } else {
          low = middle + 1;
        }
      }
      const Choice found{high, key_steps[s], bytes_of(high, keys), rms(high, s)};
      if (!best || found.bytes < best->bytes) best = found;
    }
    if (!best) return std::nullopt;
    return measured(*best);
  }

  bool holds(const Choice& choice) const {
    MorphAnimation animation = stored(choice);
    return measure(animation, options_.max_error_mm);
  }

  MorphAnimation measured(const Choice& choice) const {
    MorphAnimation animation = stored(choice);
    measure(animation, -1.0);
    return animation;
  }

  /// The values as the file holds them.
  MorphAnimation stored(const Choice& choice) const {
    MorphAnimation out;
    out.vertex_count = mesh_.vertex_count();
    out.target_count = choice.modes;
    out.keys = key_frames(mesh_.frame_count(), choice.step);
    out.base.resize(3 * out.vertex_count);
    Eigen::VectorXd base = pca_.mean.cast<double>();
    out.targets.resize(choice.modes * out.base.size());
    out.weights.resize(out.keys.size() * choice.modes);
    for (std::size_t k = 0; k < choice.modes; ++k) {
      const std::vector<double> fit = fit_linear_spline(score(k), out.keys);
      // Weights run from 0 to 1: Blender 3.4 clamps them to the range that it finds at the start.
      const auto [low, high] = std::ranges::minmax(fit);
      const double span = high > low ? high - low : 1.0;
      const auto mode = pca_.modes.col(static_cast<Eigen::Index>(k));
      std::transform(mode.begin(), mode.end(),
                     out.targets.begin() + static_cast<std::ptrdiff_t>(k * out.base.size()),
                     [span](float m) { return static_cast<float>(m * span * 1e-3); });
      base += low * mode.cast<double>();
      for (std::size_t i = 0; i < fit.size(); ++i) {
        out.weights[i * choice.modes + k] = static_cast<float>((fit[i] - low) / span);
      }
    }
    std::transform(base.begin(), base.end(), out.base.begin(),
                   [](double mm) { return static_cast<float>(mm * 1e-3); });
    return out;
  }

  /// Plays the animation as a viewer does, in single precision, and measures its errors. Stops
  /// and returns false as soon as one vertex is further off than `limit` (≥ 0).
  bool measure(MorphAnimation& a, double limit) const {
    const auto targets = static_cast<Eigen::Index>(a.target_count);
    const auto columns = static_cast<Eigen::Index>(a.base.size());
    const Eigen::Map<const Matrix> modes(a.targets.data(), targets, columns);
    const Eigen::Map<const Eigen::RowVectorXf> base(a.base.data(), columns);
    constexpr std::size_t block = 32;
    const std::size_t blocks = (mesh_.frame_count() + block - 1) / block;
    std::vector<double> sums(blocks, 0.0), largest(blocks, 0.0);
    std::atomic<bool> exceeded{false};
    parallel_for(ctx_, blocks, 1, [&](std::size_t b) {
      if (exceeded) return;
      const std::size_t first = b * block;
      const std::size_t count = std::min(block, mesh_.frame_count() - first);
      Matrix played(static_cast<Eigen::Index>(count), columns);
      played.noalias() = weights_at(a, first, count) * modes;
      played.rowwise() += base;
      for (std::size_t f = 0; f < count; ++f) {
        const float* p = played.row(static_cast<Eigen::Index>(f)).data();
        const float* x = mesh_.frame(first + f).data();
        for (Eigen::Index i = 0; i < columns; i += 3) {
          const double dx = 1e3 * double{p[i]} - x[i], dy = 1e3 * double{p[i + 1]} - x[i + 1],
                       dz = 1e3 * double{p[i + 2]} - x[i + 2];
          const double square = dx * dx + dy * dy + dz * dz;
          sums[b] += square;
          largest[b] = std::max(largest[b], square);
        }
      }
      if (limit >= 0 && largest[b] > limit * limit) exceeded = true;
    });
    double sum = 0;
    for (const double s : sums) sum += s;
    a.rms_error_mm = std::sqrt(sum / static_cast<double>(mesh_.frame_count() * a.vertex_count));
    a.max_error_mm = std::sqrt(*std::max_element(largest.begin(), largest.end()));
    return !exceeded;
  }

  static Matrix weights_at(const MorphAnimation& a, std::size_t first, std::size_t count) {
    Matrix weights(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(a.target_count));
    for (std::size_t f = 0; f < count; ++f) {
      const std::size_t frame = first + f;
      const auto after = std::upper_bound(a.keys.begin(), a.keys.end(), frame);
      const std::size_t i =
          std::min(static_cast<std::size_t>(after - a.keys.begin()) - 1, a.keys.size() - 2);
      const auto t = static_cast<float>(static_cast<double>(frame - a.keys[i]) /
                                        static_cast<double>(a.keys[i + 1] - a.keys[i]));
      for (std::size_t k = 0; k < a.target_count; ++k) {
        const float from = a.weights[i * a.target_count + k];
        const float to = a.weights[(i + 1) * a.target_count + k];
        weights(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(k)) =
            from + t * (to - from);
      }
    }
    return weights;
  }

  const AnimatedMesh& mesh_;
  const GltfOptions& options_;
  const MorphCost& cost_;
  const RunContext& ctx_;
  PcaResult pca_;
  std::vector<std::vector<double>> spline_errors_;  // per key step, per mode
};

}  // namespace

std::vector<std::size_t> key_frames(std::size_t frame_count, std::size_t step) {
  std::vector<std::size_t> keys;
  for (std::size_t f = 0; f < frame_count; f += step) keys.push_back(f);
  if (keys.back() + 1 != frame_count) keys.push_back(frame_count - 1);
  return keys;
}

std::vector<double> fit_linear_spline(const std::vector<double>& values,
                                      const std::vector<std::size_t>& keys) {
  const std::size_t n = keys.size();
  if (n == values.size()) return values;
  // Normal equations of the hat functions: tridiagonal, diagonally dominant (Thomas' algorithm).
  std::vector<double> diagonal(n, 0.0), upper(n, 0.0), right(n, 0.0);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double span = static_cast<double>(keys[i + 1] - keys[i]);
    const std::size_t end = i + 2 == n ? keys[i + 1] + 1 : keys[i + 1];
    for (std::size_t f = keys[i]; f < end; ++f) {
      const double b = static_cast<double>(f - keys[i]) / span, a = 1.0 - b;
      diagonal[i] += a * a;
      upper[i] += a * b;
      diagonal[i + 1] += b * b;
      right[i] += a * values[f];
      right[i + 1] += b * values[f];
    }
  }
  for (std::size_t i = 1; i < n; ++i) {
    const double factor = upper[i - 1] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    right[i] -= factor * right[i - 1];
  }
  std::vector<double> fit(n);
  fit[n - 1] = right[n - 1] / diagonal[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) fit[i] = (right[i] - upper[i] * fit[i + 1]) / diagonal[i];
  return fit;
}

MorphAnimation morph_animation_of(const AnimatedMesh& mesh, const GltfOptions& options,
                                  const MorphCost& cost, const RunContext& ctx) {
  return MorphFitter(mesh, options, cost, ctx).fit();
}

}  // namespace kinemesh
