#include "capture/rigid_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace kinemesh {

RigidFit fit_rigid(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                   std::span<const double> weights) {
  RigidFit fit;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  double total = 0.0;
  Eigen::Vector3d centre_from = Eigen::Vector3d::Zero();
  Eigen::Vector3d centre_to = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    total += weight(i);
    centre_from += weight(i) * from[i];
    centre_to += weight(i) * to[i];
  }
  if (total <= 0.0) return fit;
  centre_from /= total;
  centre_to /= total;
  // Column by column: sums of whole matrices would go through memory for every point.
  Eigen::Vector3d x = Eigen::Vector3d::Zero(), y = x, z = x;  // of the covariance
  Eigen::Vector3d first = x, second = x;                      // of the scatter's lower half
  double last = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d a = from[i] - centre_from;
    const Eigen::Vector3d b = weight(i) * (to[i] - centre_to);
    const Eigen::Vector3d weighted = weight(i) * a;
    x += b * a.x();
    y += b * a.y();
    z += b * a.z();
    first += weighted * a.x();
    second += weighted * a.y();
    last += weighted.z() * a.z();
  }
  Eigen::Matrix3d covariance;
  covariance << x, y, z;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  scatter.col(0) = first;
  scatter.col(1) = second;
  scatter(2, 2) = last;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign.z() = -1.0;
  fit.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  fit.translation = centre_to - fit.rotation * centre_from;
  double squares = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    squares += weight(i) * (fit.apply(from[i]) - to[i]).squaredNorm();
  }
  fit.rms = std::sqrt(squares / total);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter, Eigen::EigenvaluesOnly);
  fit.spread = std::sqrt(std::max(0.0, axes.eigenvalues().y()) / total);
  return fit;
}

}  // namespace kinemesh
