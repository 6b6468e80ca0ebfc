#include "reconstruct/marker_field.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "config/parallel.h"

namespace kinemesh {
namespace {

using Eigen::Index;

constexpr std::size_t most_frames_for_noise = 300;
constexpr double most_change = 2.5;  // in standard deviations of one coordinate
constexpr double lowest_log = -16.0, highest_log = 12.0, log_step = 0.4;

/// The displacements in the eigenbasis of the covariance, where everything is diagonal.
struct Spectrum {
  Eigen::VectorXd values;    // ascending, above 0
  Eigen::MatrixXd energies;  // markers × frames: squared coefficients, summed over x, y, z
};

Spectrum spectrum_of(const Eigen::MatrixXd& displacements, const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  Spectrum s{eigen.eigenvalues().cwiseMax(1e-10 * eigen.eigenvalues().maxCoeff()), {}};
  const Eigen::MatrixXd coefficients = eigen.eigenvectors().transpose() * displacements;
  const Index frames = displacements.cols() / 3;
  s.energies.resize(displacements.rows(), frames);
  for (Index f = 0; f < frames; ++f) {
    s.energies.col(f) = coefficients.middleCols(3 * f, 3).rowwise().squaredNorm();
  }
  return s;
}

/// Minus the log likelihood of one frame; `log_amplitude` of the signal's variance in mm².
double cost_of(const Spectrum& s, Index frame, double log_amplitude, double noise_variance) {
  const Eigen::ArrayXd v = std::exp(log_amplitude) * s.values.array() + noise_variance;
  return 0.5 * (s.energies.col(frame).array() / v).sum() + 1.5 * v.log().sum();
}

/// The same for the amplitude of most likelihood.
double least_cost(const Spectrum& s, Index frame, double noise_variance) {
  double least = std::numeric_limits<double>::infinity();
  for (double x = lowest_log; x <= highest_log; x += log_step) {
    least = std::min(least, cost_of(s, frame, x, noise_variance));
  }
  return least;
}

/// Golden section over the logarithm of the noise; a few frames tell it.
double estimate_noise(const Spectrum& s, const RunContext& ctx) {
  const auto frames = static_cast<std::size_t>(s.energies.cols());
  const std::size_t step = std::max<std::size_t>(1, frames / most_frames_for_noise);
  const auto total = [&](double log_noise) {
    const double variance = std::exp(2.0 * log_noise);
    std::vector<double> costs((frames + step - 1) / step);
    parallel_for(ctx, costs.size(), 8, [&](std::size_t i) {
      costs[i] = least_cost(s, static_cast<Index>(i * step), variance);
    });
    double sum = 0.0;
    for (const double c : costs) sum += c;
    return sum;
  };
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  double low = std::log(0.005), high = std::log(1.5);
  double a = high - ratio * (high - low), b = low + ratio * (high - low);
  double cost_a = total(a), cost_b = total(b);
  while (high - low > 0.04) {
    ctx.check_cancelled();
    if (cost_a < cost_b) {
      high = b;
      b = a;
      cost_b = cost_a;
      a = high - ratio * (high - low);
      cost_a = total(a);
    } else {
      low = a;
      a = b;
      cost_a = cost_b;
      b = low + ratio * (high - low);
      cost_b = total(b);
    }
  }
  return std::exp(0.5 * (low + high));
}

/// How much the motion of one marker says of another's size, from the prior: 1 for itself, about
/// two thirds for a neighbour, next to nothing three spacings away.
Eigen::MatrixXd kinship_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * covariance * scale.asDiagonal()).array().square().square();
}

/// Variance of the motion around each marker in one frame: what it and its kin move by more than
/// the noise explains. Absent markers do not count.
Eigen::VectorXd local_variances(const Eigen::MatrixXd& measured, const Eigen::VectorXf& absence,
                                const Eigen::MatrixXd& kinship, double noise_variance) {
  const Eigen::VectorXd present = 1.0 - absence.cast<double>().array();
  const Eigen::VectorXd energies = measured.rowwise().squaredNorm() / 3.0;
  const Eigen::VectorXd weights = kinship * present;
  const Eigen::VectorXd sums = kinship * present.cwiseProduct(energies);
  const double least = 0.01 * noise_variance;
  return (sums.array() / weights.array().max(1e-12) - noise_variance).max(least);
}

/// Posterior mean of one frame's motion; a marker's own variance grows with its absence.
Eigen::MatrixXd posterior_mean(const Eigen::MatrixXd& measured, const Eigen::VectorXf& absence,
                               const Eigen::MatrixXd& signal, double noise_variance) {
  Eigen::MatrixXd sum = signal;
  for (Index m = 0; m < sum.rows(); ++m) {
    const double c = std::min(static_cast<double>(absence[m]), 0.9999);
    const double odds = c / (1.0 - c);
    sum(m, m) += noise_variance + signal(m, m) * (1e-9 + odds * odds);
  }
  return signal * sum.llt().solve(measured);
}

/// Without noise measured markers stay as they are; the others go to what these predict.
Eigen::MatrixXd with_gaps_bridged(const Eigen::MatrixXd& measured, const Eigen::VectorXf& absence,
                                  const Eigen::MatrixXd& covariance) {
  if (absence.maxCoeff() <= 0.0F) return measured;
  const Eigen::MatrixXd predicted = posterior_mean(measured, absence, covariance, 0.0);
  return measured + absence.cast<double>().asDiagonal() * (predicted - measured);
}

}  // namespace

MarkerFieldResult settle_markers(const Eigen::MatrixXd& displacements,
                                 const Eigen::MatrixXf& absence, const Eigen::MatrixXd& covariance,
                                 const MarkerFieldOptions& options, const RunContext& ctx) {
  MarkerFieldResult result;
  result.displacements.resize(displacements.rows(), displacements.cols());
  if (displacements.size() == 0) return result;
  double noise = 0.0;
  if (options.smooth) {
    noise = options.noise_mm > 0.0 ? options.noise_mm
                                   : estimate_noise(spectrum_of(displacements, covariance), ctx);
  }
  result.noise_mm = noise;
  const Eigen::MatrixXd kinship = kinship_of(covariance);
  const auto frames = static_cast<std::size_t>(displacements.cols() / 3);
  std::vector<double> changes(frames, 0.0);
  parallel_for(ctx, frames, 4, [&](std::size_t i) {
    const auto f = static_cast<Index>(i);
    const Eigen::MatrixXd measured = displacements.middleCols(3 * f, 3);
    Eigen::MatrixXd settled;
    if (noise > 0.0) {
      const Eigen::VectorXd size =
          local_variances(measured, absence.col(f), kinship, noise * noise).cwiseSqrt();
      settled = posterior_mean(measured, absence.col(f),
                               size.asDiagonal() * covariance * size.asDiagonal(), noise * noise);
    } else {
      settled = with_gaps_bridged(measured, absence.col(f), covariance);
    }
    for (Index m = 0; m < measured.rows(); ++m) {
      const Eigen::RowVector3d off = measured.row(m) - settled.row(m);
      const double size = off.norm(), allowed = most_change * noise;
      const double present = 1.0 - static_cast<double>(absence(m, f));
      if (size > allowed) settled.row(m) += present * (1.0 - allowed / size) * off;
      if (present < 1.0) continue;
      changes[i] = std::max(changes[i], (settled.row(m) - measured.row(m)).norm());
    }
    result.displacements.middleCols(3 * f, 3) = settled.cast<float>();
  });
  result.largest_change_mm = *std::ranges::max_element(changes);
  return result;
}

Eigen::MatrixXf absence_of(const Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic>& measured,
                           double rate_hz, double fade_s) {
  const Index markers = measured.rows(), frames = measured.cols();
  const double fade = std::max(1.0, fade_s * std::max(rate_hz, 1e-9));
  Eigen::MatrixXf absence = Eigen::MatrixXf::Zero(markers, frames);
  for (Index m = 0; m < markers; ++m) {
    std::vector<double> since(static_cast<std::size_t>(frames));
    double run = std::numeric_limits<double>::infinity();
    for (Index f = 0; f < frames; ++f) {
      run = measured(m, f) != 0 ? 0.0 : run + 1.0;
      since[static_cast<std::size_t>(f)] = run;
    }
    run = std::numeric_limits<double>::infinity();
    for (Index f = frames; f-- > 0;) {
      run = measured(m, f) != 0 ? 0.0 : run + 1.0;
      const double away = std::min(run, since[static_cast<std::size_t>(f)]);
      const double t = std::clamp(away / (fade + 1.0), 0.0, 1.0);
      absence(m, f) = static_cast<float>(t * t * (3.0 - 2.0 * t));
    }
  }
  return absence;
}

}  // namespace kinemesh
