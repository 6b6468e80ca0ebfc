#include "analysis/time_warp.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "config/buffer.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// A change within this time counts as much as the value itself, s.
constexpr double derivative_time_s = 0.1;

struct Sample {
  double value, slope;
};

/// The curves as cubic splines with central differences (Catmull–Rom), held before and after.
class Curves {
 public:
  /// Smoothed by a Gaussian; each channel less its least value, all over their common RMS.
  Curves(const MotionCurves& source, double smoothing_s) : curves_(source) {
    smooth(smoothing_s * rate());
    double squares = 0.0;
    for (std::size_t c = 0; c < curves_.channel_count; ++c) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t f = 0; f < frames(); ++f) least = std::min(least, curves_.at(f, c));
      double largest = 0.0;
      for (std::size_t f = 0; f < frames(); ++f) {
        curves_.at(f, c) -= least;
        largest = std::max(largest, curves_.at(f, c));
      }
      squares += largest * largest;
    }
    scale_ = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(channels(), 1)));
    if (scale_ > 0) {
      for (double& v : curves_.values) v /= scale_;
    }
  }

  std::size_t frames() const { return curves_.frame_count; }
  std::size_t channels() const { return curves_.channel_count; }
  double rate() const { return curves_.rate_hz; }
  double duration() const { return curves_.duration_s(); }
  double scale() const { return scale_; }

  Sample at(double time_s, std::size_t channel) const {
    const double x = std::clamp(time_s, 0.0, duration()) * rate();
    const auto i = std::min(static_cast<std::size_t>(x), frames() - 2);
    const double u = x - static_cast<double>(i);
    const double p0 = value(i, channel), p1 = value(i + 1, channel);
    const double m0 = i > 0 ? (p1 - value(i - 1, channel)) / 2 : p1 - p0;
    const double m1 = i + 2 < frames() ? (value(i + 2, channel) - p0) / 2 : p1 - p0;
    const double a = 2 * (p0 - p1) + m0 + m1, b = 3 * (p1 - p0) - 2 * m0 - m1;
    const bool held = time_s < 0.0 || time_s > duration();
    return {((a * u + b) * u + m0) * u + p0, held ? 0.0 : ((3 * a * u + 2 * b) * u + m0) * rate()};
  }

  /// Root mean square of the slopes of all channels.
  double speed(double time_s) const {
    double squares = 0.0;
    for (std::size_t c = 0; c < channels(); ++c) squares += std::pow(at(time_s, c).slope, 2);
    return std::sqrt(squares / static_cast<double>(channels()));
  }

 private:
  double value(std::size_t frame, std::size_t channel) const { return curves_.at(frame, channel); }

  /// Standard deviation in frames; the curves are held at both ends.
  void smooth(double deviation) {
    if (deviation < 0.3) return;
    const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3 * deviation));
    std::vector<double> weights;
    for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
      weights.push_back(std::exp(-0.5 * std::pow(static_cast<double>(k) / deviation, 2)));
    }
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const MotionCurves source = curves_;
    const auto last = static_cast<std::ptrdiff_t>(frames()) - 1;
    for (std::ptrdiff_t f = 0; f <= last; ++f) {
      for (std::size_t c = 0; c < channels(); ++c) {
        double value = 0.0;
        for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
          const auto from = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(f + k, 0, last));
          value += weights[static_cast<std::size_t>(k + reach)] * source.at(from, c);
        }
        curves_.at(static_cast<std::size_t>(f), c) = value / sum;
      }
    }
  }

  MotionCurves curves_;
  double scale_ = 1.0;
};

/// Values and slopes at a common rate, frames × 2 channels.
struct Steps {
  std::size_t count = 0, width = 0;
  std::vector<float> values;
  const float* at(std::size_t i) const { return &values[i * width]; }
};

Steps steps_of(const Curves& curves, double rate_hz) {
  Steps steps;
  steps.count = static_cast<std::size_t>(std::lround(curves.duration() * rate_hz)) + 1;
  steps.width = 2 * curves.channels();
  steps.values.reserve(steps.count * steps.width);
  for (std::size_t i = 0; i < steps.count; ++i) {
    for (std::size_t c = 0; c < curves.channels(); ++c) {
      const Sample s = curves.at(static_cast<double>(i) / rate_hz, c);
      steps.values.push_back(static_cast<float>(s.value));
      steps.values.push_back(static_cast<float>(derivative_time_s * s.slope));
    }
  }
  return steps;
}

float squared_distance(const float* a, const float* b, std::size_t width) {
  float sum = 0.0F;
  for (std::size_t k = 0; k < width; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum / static_cast<float>(width);
}

enum Move : uint8_t { both, in_a, in_b };

/// Where each step of A is in B, in steps: the mean of those it is joined with.
std::vector<double> walk_back(const Buffer<uint8_t>& moves, std::size_t n, std::size_t m) {
  std::vector<double> sum(n, 0.0), count(n, 0.0);
  for (std::size_t i = n - 1, j = m - 1;;) {
    sum[i] += static_cast<double>(j);
    count[i] += 1.0;
    if (i == 0 && j == 0) break;
    const uint8_t move = moves[i * m + j];
    if (move != in_b) --i;
    if (move != in_a) --j;
  }
  for (std::size_t i = 0; i < n; ++i) sum[i] /= count[i];
  return sum;
}

std::vector<double> warp_by_steps(const Steps& a, const Steps& b, double step_cost,
                                  const RunContext& ctx) {
  const std::size_t n = a.count, m = b.count;
  Buffer<uint8_t> moves(n * m);
  std::vector<double> before(m, std::numeric_limits<double>::infinity()), now(m);
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 64 == 0) ctx.check_cancelled();
    for (std::size_t j = 0; j < m; ++j) {
      const double diagonal = i == 0 || j == 0 ? (i == j ? 0.0 : 1e300) : before[j - 1];
      const double along_a = i > 0 ? before[j] + step_cost : 1e300;
      const double along_b = j > 0 ? now[j - 1] + step_cost : 1e300;
      double best = diagonal;
      uint8_t move = both;
      if (along_a < best) best = along_a, move = in_a;
      if (along_b < best) best = along_b, move = in_b;
      moves[i * m + j] = move;
      now[j] = best + static_cast<double>(squared_distance(a.at(i), b.at(j), a.width));
    }
    std::swap(before, now);
  }
  return walk_back(moves, n, m);
}

/// The smooth warp that brings B's curves onto A's, from a first one.
class Refinement {
 public:
  Refinement(const Curves& a, const Curves& b, double smoothing_s) : a_(a), b_(b) {
    const double dt = 1.0 / a.rate();
    double curvature = 0.0;
    for (std::size_t i = 0; i < a.frames(); ++i) {
      curvature +=
          std::pow(a.speed(static_cast<double>(i) * dt), 2) / static_cast<double>(a.frames());
    }
    bend_ = curvature * std::pow(smoothing_s, 4) / std::pow(dt, 4);
    stretch_ = 1e-3 * curvature * std::pow(smoothing_s, 2) / std::pow(dt, 2);
  }

  void run(std::vector<double>& warp, const RunContext& ctx) const {
    constexpr int most = 30;
    constexpr double settled_s = 1e-6;
    double energy = energy_of(warp);
    for (int iteration = 0; iteration < most; ++iteration) {
      ctx.check_cancelled();
      const Eigen::VectorXd step = step_from(warp);
      double part = 1.0;
      std::vector<double> tried;
      double tried_energy = energy;
      for (; part > 1e-3; part /= 2) {
        tried = moved(warp, step, part);
        tried_energy = energy_of(tried);
        if (tried_energy < energy) break;
      }
      if (!(tried_energy < energy)) return;
      warp = std::move(tried);
      energy = tried_energy;
      if (part * step.cwiseAbs().maxCoeff() < settled_s) return;
    }
  }

 private:
  static std::vector<double> moved(std::vector<double> warp, const Eigen::VectorXd& step,
                                   double part) {
    double last = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < warp.size(); ++i) {
      last = std::max(last, warp[i] + part * step[static_cast<Eigen::Index>(i)]);
      warp[i] = last;
    }
    return warp;
  }

  double energy_of(const std::vector<double>& w) const {
    const double dt = 1.0 / a_.rate(), channels = static_cast<double>(a_.channels());
    double sum = 0.0;
    for (std::size_t i = 0; i < w.size(); ++i) {
      for (std::size_t c = 0; c < a_.channels(); ++c) {
        const double r = b_.at(w[i], c).value - a_.at(static_cast<double>(i) * dt, c).value;
        sum += r * r / channels;
      }
      if (i > 0) sum += stretch_ * std::pow(w[i] - w[i - 1] - dt, 2);
      if (i > 1) sum += bend_ * std::pow(w[i] - 2 * w[i - 1] + w[i - 2], 2);
    }
    return sum;
  }

  Eigen::VectorXd step_from(const std::vector<double>& w) const {
    const auto n = static_cast<Eigen::Index>(w.size());
    const double dt = 1.0 / a_.rate(), channels = static_cast<double>(a_.channels());
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(15 * w.size());
    Eigen::VectorXd downhill = Eigen::VectorXd::Zero(n);
    // Adds the row Σ k_j w_j = r of least squares, weighted.
    const auto add = [&](Eigen::Index first, std::initializer_list<double> row, double residual,
                         double weight) {
      Eigen::Index i = first;
      for (const double p : row) {
        Eigen::Index j = first;
        for (const double q : row) entries.emplace_back(i, j++, weight * p * q);
        downhill[i++] -= weight * p * residual;
      }
    };
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      for (std::size_t c = 0; c < a_.channels(); ++c) {
        const Sample b = b_.at(w[at], c);
        add(i, {b.slope}, b.value - a_.at(static_cast<double>(i) * dt, c).value, 1.0 / channels);
      }
      if (i > 0) add(i - 1, {-1.0, 1.0}, w[at] - w[at - 1] - dt, stretch_);
      if (i > 1) add(i - 2, {1.0, -2.0, 1.0}, w[at] - 2 * w[at - 1] + w[at - 2], bend_);
    }
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    for (Eigen::Index i = 0; i < n; ++i) matrix.coeffRef(i, i) += 1e-12 + 1e-9 * stretch_;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    return solver.solve(downhill);
  }

  const Curves& a_;
  const Curves& b_;
  double bend_ = 0.0, stretch_ = 0.0;
};

/// RMS of B at the warped times less A, over the RMS of A.
double difference_of(const Curves& a, const Curves& b, const std::vector<double>& warp) {
  double differences = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < warp.size(); ++i) {
    for (std::size_t c = 0; c < a.channels(); ++c) {
      const double value = a.at(static_cast<double>(i) / a.rate(), c).value;
      differences += std::pow(b.at(warp[i], c).value - value, 2);
      squares += value * value;
    }
  }
  return squares > 0 ? std::sqrt(differences / squares) : 0.0;
}

void mark_moving(const Curves& a, double still, TimeWarpResult& result) {
  std::vector<double> speeds(a.frames());
  for (std::size_t i = 0; i < a.frames(); ++i) {
    speeds[i] = a.speed(static_cast<double>(i) / a.rate());
  }
  const double least = still * *std::ranges::max_element(speeds);
  std::vector<double> delays;
  for (std::size_t i = 0; i < a.frames(); ++i) {
    result.determined.push_back(speeds[i] > least ? 1 : 0);
    if (speeds[i] > least) delays.push_back(result.b_of_a_s[i] - static_cast<double>(i) / a.rate());
  }
  const auto middle = delays.begin() + static_cast<std::ptrdiff_t>(delays.size() / 2);
  std::nth_element(delays.begin(), middle, delays.end());
  result.delay_s = *middle;
}

void refuse_unusable(const MotionCurves& a, const MotionCurves& b) {
  if (a.channel_count != b.channel_count || a.channel_count == 0) {
    throw UsageError({.what = "curves of " + count_of(a.channel_count, "channel") + " and of " +
                              count_of(b.channel_count, "channel") + " cannot be aligned"});
  }
  for (const MotionCurves* curves : {&a, &b}) {
    if (!(curves->rate_hz > 0)) {
      throw UsageError(
          {.what = "the frame rate of an animation is not known", .remedy = "Give it with --rate"});
    }
    if (curves->frame_count < 3) {
      throw NoResultError({.what = "an animation of " + count_of(curves->frame_count, "frame") +
                                   " has no course in time"});
    }
  }
}

}  // namespace

void TimeWarpOptions::declare(ParameterSet& p) {
  p.group("time", "Alignment in time");
  p.number("time-smoothing", smoothing_s,
           {.unit = "s",
            .min = 0.0,
            .max = 10.0,
            .help = "changes of speed within this time are smoothed out of the alignment"});
  p.number("time-step-cost", step_cost,
           {.min = 0.0,
            .max = 10.0,
            .help = "cost of time going on in one performance alone, for each frame"});
  p.number("time-still", still,
           {.min = 0.0,
            .max = 0.9,
            .help = "slower than this part of the fastest change, nothing moves"});
  p.number("time-coarse-frames", coarse_frames,
           {.min = 100,
            .max = 20000,
            .help = "longer performances are first aligned at a lower frame rate"});
}

double TimeWarpResult::at(double a_s) const {
  const double x = a_s * rate_hz;
  const double last = static_cast<double>(b_of_a_s.size() - 1);
  if (x <= 0) return b_of_a_s.front() + a_s;
  if (x >= last) return b_of_a_s.back() + a_s - last / rate_hz;
  const auto i = static_cast<std::size_t>(x);
  return std::lerp(b_of_a_s[i], b_of_a_s[i + 1], x - static_cast<double>(i));
}

TimeWarpResult align_in_time(const MotionCurves& a, const MotionCurves& b,
                             const TimeWarpOptions& options, const RunContext& ctx) {
  options.validate();
  refuse_unusable(a, b);
  const Curves first(a, options.smoothing_s / 2), second(b, options.smoothing_s / 2);
  if (!(first.scale() > 0) || !(second.scale() > 0)) {
    throw NoResultError({.what = "nothing moves in one of the animations: they cannot be aligned",
                         .remedy = "Choose takes with motion"});
  }
  const double longest = std::max(first.duration(), second.duration());
  const double rate = std::min(std::max(first.rate(), second.rate()),
                               static_cast<double>(options.coarse_frames - 1) / longest);
  const std::vector<double> steps = warp_by_steps(steps_of(first, rate), steps_of(second, rate),
                                                  options.step_cost, ctx.part(0.0, 0.7, "time"));
  TimeWarpResult result;
  result.rate_hz = first.rate();
  std::vector<double> stretched;
  for (std::size_t f = 0; f < first.frames(); ++f) {
    const double time = static_cast<double>(f) / first.rate();
    const double x = std::min(time * rate, static_cast<double>(steps.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(x), steps.size() - 2);
    result.b_of_a_s.push_back(std::lerp(steps[i], steps[i + 1], x - static_cast<double>(i)) / rate);
    stretched.push_back(time * second.duration() / first.duration());
  }
  Refinement(first, second, options.smoothing_s).run(result.b_of_a_s, ctx);
  result.amplitude = second.scale() / first.scale();
  result.difference = difference_of(first, second, result.b_of_a_s);
  result.difference_unwarped = difference_of(first, second, stretched);
  mark_moving(first, options.still, result);
  ctx.progress(1.0);
  return result;
}

}  // namespace kinemesh
