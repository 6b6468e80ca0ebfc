#include "capture/fill/spline.h"

#include <Eigen/LU>
#include <cmath>

namespace kinemesh::fill {

Eigen::MatrixXd natural_spline(int degree, const Eigen::VectorXd& knots,
                               const Eigen::MatrixXd& values, const Eigen::VectorXd& queries) {
  // f(t) = Σ cᵢ |t − tᵢ|^degree + a polynomial below the order n, with Σ cᵢ tᵢᵏ = 0 for k < n.
  const Eigen::Index n = (degree + 1) / 2;
  const Eigen::Index count = knots.size();
  const double centre = 0.5 * (knots[0] + knots[count - 1]);
  const double scale = std::max(0.5 * (knots[count - 1] - knots[0]), 1e-300);
  const auto basis = [&](const Eigen::VectorXd& at) {
    Eigen::MatrixXd rows(at.size(), count + n);
    for (Eigen::Index r = 0; r < at.size(); ++r) {
      for (Eigen::Index k = 0; k < count; ++k) {
        const double d = std::abs(at[r] - knots[k]) / scale;
        rows(r, k) = degree == 1 ? d : degree == 3 ? d * d * d : d * d * d * d * d;
      }
      double power = 1.0;
      for (Eigen::Index k = 0; k < n; ++k, power *= (at[r] - centre) / scale) {
        rows(r, count + k) = power;
      }
    }
    return rows;
  };
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(count + n, count + n);
  system.topRows(count) = basis(knots);
  system.bottomLeftCorner(n, count) = system.topRightCorner(count, n).transpose();
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count + n, values.cols());
  right.topRows(count) = values;
  return basis(queries) * Eigen::MatrixXd(system.fullPivLu().solve(right));
}

std::optional<Estimate> fill_spline(const Trajectories& take, const GapAt& gap, int degree) {
  constexpr std::size_t side = 8;
  const FrameRange frames = gap.frames;
  if (frames.begin == 0 || frames.end == take.frames()) return std::nullopt;
  std::vector<std::size_t> knots;
  for (std::size_t f = frames.begin; f-- > 0 && knots.size() < side;) {
    if (take.measured(gap.marker, f)) knots.insert(knots.begin(), f);
  }
  const std::size_t before = knots.size();
  for (std::size_t f = frames.end; f < take.frames() && knots.size() < before + side; ++f) {
    if (take.measured(gap.marker, f)) knots.push_back(f);
  }
  const auto count = static_cast<Eigen::Index>(knots.size());
  if (count < (degree + 1) / 2) return std::nullopt;
  Eigen::VectorXd times(count);
  Eigen::MatrixXd values(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t f = knots[static_cast<std::size_t>(k)];
    times[k] = static_cast<double>(f);
    values.row(k) = take.at(gap.marker, f).transpose();
  }
  const auto length = static_cast<Eigen::Index>(frames.size());
  const Eigen::VectorXd queries = Eigen::VectorXd::LinSpaced(
      length, static_cast<double>(frames.begin), static_cast<double>(frames.end - 1));
  const Eigen::RowVector3d offset = values.colwise().mean();
  const Eigen::MatrixXd at =
      natural_spline(degree, times, values.rowwise() - offset, queries).rowwise() + offset;
  Estimate out;
  for (Eigen::Index i = 0; i < length; ++i) out.positions.emplace_back(at.row(i).transpose());
  return out;
}

}  // namespace kinemesh::fill
