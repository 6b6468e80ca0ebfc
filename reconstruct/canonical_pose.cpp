#include "reconstruct/canonical_pose.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace kinemesh {
namespace {

/// Columns are the principal axes, largest spread first, a right-handed frame whose first two
/// axes point along the heavier tail.
Eigen::Matrix3d principal_axes(const Points& centred) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& p : centred) covariance += p * p.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  Eigen::Matrix3d axes = solver.eigenvectors().rowwise().reverse();
  std::array<double, 3> tail{};
  for (int k = 0; k < 3; ++k) {
    for (const auto& p : centred) tail[k] += std::pow(p.dot(axes.col(k)), 3);
  }
  // A symmetric cloud has no tail along one axis: that one follows from the other two.
  const auto weakest =
      std::min_element(tail.begin(), tail.end(),
                       [](double a, double b) { return std::abs(a) < std::abs(b); }) -
      tail.begin();
  for (int k = 0; k < 3; ++k) {
    if (k != weakest && tail[k] < 0) axes.col(k) *= -1;
  }
  if (axes.determinant() < 0) axes.col(weakest) *= -1;
  return axes;
}

/// A smooth field without symmetry, of length ≤ √3; p in units of the spread.
Eigen::Vector3d untie(const Eigen::Vector3d& p) {
  return {std::sin(3.1 * p.x() + 5.3 * p.y() + 7.7 * p.z() + 0.3),
          std::sin(6.7 * p.x() - 2.9 * p.y() + 4.1 * p.z() + 1.1),
          std::sin(-4.7 * p.x() + 8.3 * p.y() + 2.3 * p.z() + 2.7)};
}

}  // namespace

CanonicalPose canonical_pose(const Points& points) {
  const auto n = static_cast<double>(points.size());
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const auto& p : points) centroid += p / n;
  Points centred;
  double spread = 0.0;
  for (const auto& p : points) {
    centred.emplace_back(p - centroid);
    spread += centred.back().squaredNorm() / n;
  }
  spread = std::sqrt(spread);
  const Eigen::Matrix3d axes = principal_axes(centred);
  constexpr double untie_size = 3e-5;
  for (auto& p : centred) {
    p = axes.transpose() * p;
    if (spread > 0) p += untie_size * spread * untie(p / spread);
  }

  CanonicalPose pose;
  pose.original.resize(points.size());
  std::iota(pose.original.begin(), pose.original.end(), VertexIndex{0});
  std::sort(pose.original.begin(), pose.original.end(), [&](VertexIndex a, VertexIndex b) {
    const auto &p = centred[a], &q = centred[b];
    return std::tie(p.x(), p.y(), p.z(), a) < std::tie(q.x(), q.y(), q.z(), b);
  });
  for (const VertexIndex v : pose.original) pose.points.push_back(centred[v]);
  return pose;
}

}  // namespace kinemesh
