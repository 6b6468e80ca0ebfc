// The smooth deformation of space that comes nearest to a map of a surface. Private to analysis/.
//
// What neither shape nor motion tells (a neck, a temple) still moves with what is around it: people
// differ by deformations that are smooth in space, also across what is far along the surface.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace kinemesh::full_matching {

class SmoothDeformation {
 public:
  static constexpr int terms = 20;  ///< of a cubic polynomial in three coordinates

  /// Fits cubic polynomials of the position to the images, by area.
  void fit(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3d> images,
           std::span<const double> areas);
  Eigen::Vector3d operator()(const Eigen::Vector3d& position) const;
  /// Mean squared distance of the images from where the deformation leads, over their variance.
  double unexplained() const { return unexplained_; }

 private:
  Eigen::Matrix<double, terms, 1> terms_of(const Eigen::Vector3d& position) const;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double size_ = 1.0, unexplained_ = 1.0;
  Eigen::Matrix<double, terms, 3> coefficients_ = Eigen::Matrix<double, terms, 3>::Zero();
};

}  // namespace kinemesh::full_matching
