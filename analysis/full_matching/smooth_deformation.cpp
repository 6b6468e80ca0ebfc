#include "analysis/full_matching/smooth_deformation.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace kinemesh::full_matching {

namespace {

constexpr double ridge = 1e-6;  // of the moments: flat surfaces leave terms undetermined

}  // namespace

Eigen::Matrix<double, SmoothDeformation::terms, 1> SmoothDeformation::terms_of(
    const Eigen::Vector3d& position) const {
  const Eigen::Vector3d p = (position - centre_) / size_;
  const double x = p.x(), y = p.y(), z = p.z();
  Eigen::Matrix<double, terms, 1> t;
  t << 1.0, x, y, z, x * x, y * y, z * z, x * y, y * z, z * x, x * x * x, y * y * y, z * z * z,
      x * x * y, x * x * z, y * y * x, y * y * z, z * z * x, z * z * y, x * y * z;
  return t;
}

void SmoothDeformation::fit(std::span<const Eigen::Vector3d> positions,
                            std::span<const Eigen::Vector3d> images,
                            std::span<const double> areas) {
  double total = 0.0;
  Eigen::Vector3d mean_image = Eigen::Vector3d::Zero();
  centre_.setZero();
  for (std::size_t v = 0; v < positions.size(); ++v) {
    total += areas[v];
    centre_ += areas[v] * positions[v];
    mean_image += areas[v] * images[v];
  }
  centre_ /= total;
  mean_image /= total;
  double square = 0.0, variance = 0.0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    square += areas[v] * (positions[v] - centre_).squaredNorm();
    variance += areas[v] * (images[v] - mean_image).squaredNorm();
  }
  size_ = std::sqrt(square / total);
  Eigen::Matrix<double, terms, terms> moments = Eigen::Matrix<double, terms, terms>::Zero();
  Eigen::Matrix<double, terms, 3> sides = Eigen::Matrix<double, terms, 3>::Zero();
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Eigen::Matrix<double, terms, 1> t = terms_of(positions[v]);
    moments.noalias() += areas[v] / total * t * t.transpose();
    sides.noalias() += areas[v] / total * t * images[v].transpose();
  }
  moments.diagonal().array() += ridge;
  coefficients_ = moments.ldlt().solve(sides);
  double rest = 0.0;
  for (std::size_t v = 0; v < positions.size(); ++v)
    rest += areas[v] * ((*this)(positions[v]) - images[v]).squaredNorm();
  unexplained_ = variance > 0.0 ? rest / variance : 1.0;
}

Eigen::Vector3d SmoothDeformation::operator()(const Eigen::Vector3d& position) const {
  return coefficients_.transpose() * terms_of(position);
}

}  // namespace kinemesh::full_matching
