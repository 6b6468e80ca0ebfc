#include "capture/fill/gaussian_process.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/fill/calibration.h"

namespace kinemesh::fill {
namespace {

struct Setting {
  double length = 1.0;
  double time_s = 1.0;
};

/// Fitted to the rows under one setting.
struct Fitted {
  Dense factor;           ///< U of the covariance, UᵀU
  Eigen::MatrixXd alpha;  ///< K⁻¹ y
  double scale = 0.0;     ///< s²: variance in mm² per unit of covariance
  double likelihood = -std::numeric_limits<double>::infinity();  ///< log, up to a constant
};

/// Covariances of the training set, in parts that settings share.
class Covariance {
 public:
  Covariance(const TrainingSet& set, double rate_hz, const ProcessOptions& options)
      : set_(set),
        rate_hz_(rate_hz),
        options_(options),
        frames_(set.rows),
        time_amplitude_(amplitude(set, rate_hz, options)),
        gram_(gram(set.inputs)) {
    frames_.insert(frames_.end(), set.gap.begin(), set.gap.end());
  }

  std::size_t rows() const { return set_.rows.size(); }
  double time_amplitude() const { return time_amplitude_; }
  double prior() const { return options_.quadratic + time_amplitude_ + options_.constant; }

  /// Between the training rows `chosen` (upper triangle).
  Dense among(const std::vector<std::size_t>& chosen, const Setting& setting, double nugget) const {
    Dense k(chosen.size(), chosen.size());
    const std::vector<double> time = time_table(setting);
    for (std::size_t a = 0; a < chosen.size(); ++a) {
      double* row = k.row(a);
      for (std::size_t b = a; b < chosen.size(); ++b) {
        row[b] = value(chosen[a], chosen[b], setting, time);
      }
      row[a] += nugget;
    }
    return k;
  }

  /// Between training rows and gap frames: rows × gap.
  Dense to_gap(const Setting& setting) const {
    const std::size_t n = rows();
    Dense k(n, set_.gap.size());
    const std::vector<double> time = time_table(setting);
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < set_.gap.size(); ++b) k(a, b) = value(a, n + b, setting, time);
    }
    return k;
  }

  /// Prior variance of gap frame b.
  double at_gap(std::size_t b) const {
    const std::size_t i = rows() + b;
    return options_.linear * gram_(i, i) + prior();
  }

 private:
  static double amplitude(const TrainingSet& set, double rate_hz, const ProcessOptions& options) {
    const double gap_s = static_cast<double>(set.gap.size()) / (rate_hz > 0.0 ? rate_hz : 60.0);
    return std::clamp(options.time_over_gap_s / gap_s, 8.0, 40.0);
  }

  /// a ≤ b.
  double value(std::size_t a, std::size_t b, const Setting& setting,
               const std::vector<double>& time) const {
    const double product = gram_(a, b);
    const double distance = std::max(0.0, gram_(a, a) + gram_(b, b) - 2.0 * product);
    const std::size_t apart =
        frames_[a] < frames_[b] ? frames_[b] - frames_[a] : frames_[a] - frames_[b];
    return options_.linear * product +
           options_.quadratic / (1.0 + distance / (2.0 * setting.length * setting.length)) +
           time[std::min(apart, time.size() - 1)] + options_.constant;
  }

  /// Matérn 7/2 by frames apart; the last entry stands for all farther ones.
  std::vector<double> time_table(const Setting& setting) const {
    std::vector<double> table;
    const double frames = rate_hz_ > 0.0 ? rate_hz_ * setting.time_s : 60.0 * setting.time_s;
    for (std::size_t d = 0;; ++d) {
      const double r = std::sqrt(7.0) * static_cast<double>(d) / frames;
      const double value = (1.0 + r + 0.4 * r * r + r * r * r / 15.0) * std::exp(-r);
      table.push_back(value < 1e-12 ? 0.0 : time_amplitude_ * value);
      if (!(table.back() > 0.0)) return table;
    }
  }

  const TrainingSet& set_;
  double rate_hz_;
  const ProcessOptions& options_;
  std::vector<std::size_t> frames_;
  double time_amplitude_;
  Dense gram_;
};

Dense as_dense(const Eigen::MatrixXd& m) {
  Dense out(static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols()));
  for (std::size_t r = 0; r < out.rows(); ++r) {
    for (std::size_t c = 0; c < out.columns(); ++c) {
      out(r, c) = m(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
    }
  }
  return out;
}

/// The outputs of the chosen rows given their covariance; likelihood −∞ when it is not definite.
Fitted fit(Dense covariance, const Eigen::MatrixXd& outputs,
           const std::vector<std::size_t>& chosen) {
  Fitted out;
  Eigen::MatrixXd y(static_cast<Eigen::Index>(chosen.size()), outputs.cols());
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    y.row(static_cast<Eigen::Index>(i)) = outputs.row(static_cast<Eigen::Index>(chosen[i]));
  }
  if (!cholesky(covariance)) return out;
  Dense z = as_dense(y);
  solve_transposed(covariance, z);
  double squares = 0.0;
  double log_determinant = 0.0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    for (std::size_t c = 0; c < z.columns(); ++c) squares += z(i, c) * z(i, c);
    log_determinant += std::log(covariance(i, i));
  }
  constexpr double least_mm2 = 1e-12;  // a marker that does not move at all
  const double values = static_cast<double>(chosen.size() * z.columns());
  out.scale = std::max(squares / values, least_mm2);
  out.likelihood =
      -0.5 * values * std::log(out.scale) - static_cast<double>(z.columns()) * log_determinant;
  solve(covariance, z);
  out.alpha.resize(y.rows(), y.cols());
  for (Eigen::Index i = 0; i < y.rows(); ++i) {
    for (Eigen::Index c = 0; c < y.cols(); ++c) {
      out.alpha(i, c) = z(static_cast<std::size_t>(i), static_cast<std::size_t>(c));
    }
  }
  out.factor = std::move(covariance);
  return out;
}

/// Rows next to the gap and every so many of the others: where noise is told from motion.
std::vector<std::size_t> probe_rows(const TrainingSet& set, std::size_t most) {
  constexpr std::size_t near_frames = 40;
  std::vector<std::size_t> near;
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    const std::size_t f = set.rows[i];
    const bool is_near = f + near_frames >= set.gap.front() && f <= set.gap.back() + near_frames;
    (is_near ? near : far).push_back(i);
  }
  const std::size_t wanted = std::min(far.size(), most - std::min(most, near.size()));
  for (std::size_t k = 0; k < wanted; ++k) near.push_back(far[k * far.size() / wanted]);
  std::ranges::sort(near);
  return near;
}

/// The variance that no input explains, in units of the covariance: the most likely one,
/// at least a millionth of the time term's (less lets the inputs be taken as exact, which harms).
double choose_nugget(const Covariance& covariance, const TrainingSet& set, const Setting& setting,
                     const ProcessOptions& options) {
  const std::vector<std::size_t> rows = probe_rows(set, options.noise_rows);
  double best = 1e-6 * covariance.time_amplitude();
  double best_likelihood = -std::numeric_limits<double>::infinity();
  const Dense base = covariance.among(rows, setting, 0.0);
  for (double factor = 1e-6; factor < 20.0; factor *= options.noise_step) {
    const double nugget = factor * covariance.time_amplitude();
    Dense k = base;
    for (std::size_t i = 0; i < rows.size(); ++i) k(i, i) += nugget;
    const Fitted fitted = fit(std::move(k), set.outputs, rows);
    if (fitted.likelihood <= best_likelihood) continue;
    best_likelihood = fitted.likelihood;
    best = nugget;
  }
  return best;
}

std::vector<Setting> settings_for(const TrainingSet& set, const ProcessOptions& options) {
  std::vector<Setting> settings;
  if (set.donors == 0) {  // time alone: it must bridge long gaps, too
    for (const double time : options.times_s) {
      settings.push_back({1.0, time});
      settings.push_back({1.0, 8.0 * time});
    }
    return settings;
  }
  for (const double length : options.lengths) {
    for (const double time : options.times_s) settings.push_back({length, time});
  }
  return settings;
}

/// Estimates of all settings and their average.
struct Average {
  Eigen::MatrixXd mean;      ///< gap × 3, mm
  Eigen::VectorXd variance;  ///< gap: of one coordinate of a noisy measurement, mm²
};

/// Predictive variance at the gap's frames, noise included.
Eigen::VectorXd predictive_variance(const Covariance& covariance, const Fitted& fitted, Dense cross,
                                    double nugget) {
  solve_transposed(fitted.factor, cross);
  Eigen::VectorXd variance(static_cast<Eigen::Index>(cross.columns()));
  for (std::size_t b = 0; b < cross.columns(); ++b) {
    double explained = 0.0;
    for (std::size_t a = 0; a < cross.rows(); ++a) explained += cross(a, b) * cross(a, b);
    variance[static_cast<Eigen::Index>(b)] =
        fitted.scale * (std::max(0.0, covariance.at_gap(b) - explained) + nugget);
  }
  return variance;
}

Eigen::MatrixXd predictive_mean(const Fitted& fitted, const Dense& cross) {
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(cross.columns()), 3);
  for (std::size_t a = 0; a < cross.rows(); ++a) {
    for (std::size_t b = 0; b < cross.columns(); ++b) {
      mean.row(static_cast<Eigen::Index>(b)) +=
          cross(a, b) * fitted.alpha.row(static_cast<Eigen::Index>(a));
    }
  }
  return mean;
}

/// Fits every setting, averages the estimates by softened likelihood, and calibrates the variance
/// of the likeliest on left-out blocks.
Average average(const Covariance& covariance, const TrainingSet& set,
                const std::vector<Setting>& settings, double nugget, double softening) {
  std::vector<std::size_t> all(set.rows.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::vector<Eigen::MatrixXd> means;
  std::vector<double> likelihoods;
  Fitted best;
  std::size_t best_setting = 0;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    Fitted fitted = fit(covariance.among(all, settings[s], nugget), set.outputs, all);
    if (fitted.factor.rows() == 0) continue;
    likelihoods.push_back(fitted.likelihood);
    means.push_back(predictive_mean(fitted, covariance.to_gap(settings[s])));
    if (fitted.likelihood > best.likelihood) {
      best = std::move(fitted);
      best_setting = s;
    }
  }
  const auto gap = static_cast<Eigen::Index>(set.gap.size());
  Average out{Eigen::MatrixXd::Zero(gap, 3), Eigen::VectorXd::Zero(gap)};
  const double values = 3.0 * static_cast<double>(all.size());
  double total = 0.0;
  for (double& l : likelihoods) {
    l = std::exp(softening * 3.0 * (l - best.likelihood) / values);
    total += l;
  }
  for (std::size_t s = 0; s < means.size(); ++s) out.mean += likelihoods[s] / total * means[s];
  const double factor = band_factor(set, best.factor, best.alpha, best.scale);
  out.variance =
      factor * factor *
      predictive_variance(covariance, best, covariance.to_gap(settings[best_setting]), nugget);
  for (std::size_t s = 0; s < means.size(); ++s) {
    out.variance += likelihoods[s] / total * (means[s] - out.mean).rowwise().squaredNorm() / 3.0;
  }
  return out;
}

}  // namespace

Estimate estimate_gap(const TrainingSet& set, double rate_hz, double noise,
                      const ProcessOptions& options) {
  const Covariance covariance(set, rate_hz, options);
  const std::vector<Setting> settings = settings_for(set, options);
  const double nugget = choose_nugget(covariance, set, settings[settings.size() / 2], options);
  const Average estimate = average(covariance, set, settings, nugget, options.softening);
  const auto rows = static_cast<Eigen::Index>(set.rows.size());
  const double known = rows > 0 ? set.guess.topRows(rows).rowwise().norm().maxCoeff() : 0.0;
  Estimate out;
  for (std::size_t i = 0; i < set.gap.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Eigen::RowVector3d guess = set.guess.row(rows + row);
    const Eigen::Vector3d p = (estimate.mean.row(row) + set.mean_output + guess).transpose();
    out.positions.push_back(set.poses[i].apply(p));
    // The uncertainty of the true position: without the noise of a measurement there.
    const double total = options.widening * options.widening * estimate.variance[row];
    // Both are estimates; how much of their sum the noise is, is known to a seventh at best.
    constexpr double least_share = 0.15;
    // Where the surroundings go farther than in any row, how well they tell is not known.
    constexpr double doubt = 0.1;
    const double beyond = doubt * std::max(0.0, guess.norm() - known);
    out.sd.push_back(std::sqrt(std::max(total - noise, least_share * total) + beyond * beyond));
  }
  return out;
}

double noise_variance(const Trajectories& take, std::size_t marker) {
  std::vector<double> sizes;
  for (std::size_t f = 0; f + 4 < take.frames(); ++f) {
    if (!take.measured_throughout(marker, {f, f + 5})) continue;
    const Eigen::Vector3d d = take.at(marker, f) - 4.0 * take.at(marker, f + 1) +
                              6.0 * take.at(marker, f + 2) - 4.0 * take.at(marker, f + 3) +
                              take.at(marker, f + 4);
    for (Eigen::Index c = 0; c < 3; ++c) sizes.push_back(std::abs(d[c]));
  }
  if (sizes.empty()) return 0.0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  constexpr double median_of_normal = 0.67448975;
  constexpr double gain = 70.0;  // 1² + 4² + 6² + 4² + 1²
  const double sd = *middle / median_of_normal;
  return sd * sd / gain;
}

}  // namespace kinemesh::fill
