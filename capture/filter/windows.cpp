#include "capture/filter/windows.h"

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

namespace kinemesh::filter {
namespace {

/// Row r: the weights that give the fitted polynomial's value at sample r of the window.
Eigen::MatrixXd fit_weights(int window, int degree) {
  const double half = 0.5 * (window - 1);
  Eigen::MatrixXd powers(window, degree + 1);
  for (int i = 0; i < window; ++i) {
    const double t = half > 0.0 ? (i - half) / half : 0.0;
    double power = 1.0;
    for (int k = 0; k <= degree; ++k, power *= t) powers(i, k) = power;
  }
  // The projection onto the polynomials, from an orthonormal basis of them.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(powers);
  const Eigen::MatrixXd basis = qr.householderQ() * Eigen::MatrixXd::Identity(window, degree + 1);
  return basis * basis.transpose();
}

/// Calls `reduce(window)` with the values around each sample.
template <class Reduce>
void slide(std::span<double> values, int window, Reduce reduce) {
  if (values.empty()) return;
  const auto half = static_cast<std::size_t>(window / 2);
  std::vector<double> wide(half, values.front());
  wide.insert(wide.end(), values.begin(), values.end());
  wide.insert(wide.end(), half, values.back());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = reduce(std::span<const double>(wide).subspan(i, static_cast<std::size_t>(window)));
  }
}

}  // namespace

void savitzky_golay(std::span<double> values, int window, int degree) {
  const auto n = static_cast<Eigen::Index>(values.size());
  if (n < window) return;
  const Eigen::MatrixXd weights = fit_weights(window, degree);
  const Eigen::VectorXd in = Eigen::Map<const Eigen::VectorXd>(values.data(), n);
  Eigen::Map<Eigen::VectorXd> out(values.data(), n);
  const Eigen::Index half = window / 2;
  for (Eigen::Index i = half; i + half < n; ++i) {
    out[i] = weights.row(half).dot(in.segment(i - half, window));
  }
  out.head(half) = weights.topRows(half) * in.head(window);
  out.tail(half) = weights.bottomRows(half) * in.tail(window);
}

void moving_average(std::span<double> values, int window) {
  slide(values, window, [](std::span<const double> around) {
    double sum = 0.0;
    for (const double v : around) sum += v;
    return sum / static_cast<double>(around.size());
  });
}

void moving_median(std::span<double> values, int window) {
  std::vector<double> sorted;
  slide(values, window, [&sorted](std::span<const double> around) {
    sorted.assign(around.begin(), around.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    return *middle;
  });
}

}  // namespace kinemesh::filter
