// The rotation and translation that bring one set of points closest to another.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

namespace kinemesh {

struct RigidFit {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< proper: determinant +1
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   ///< mm
  double rms = 0.0;     ///< mm, weighted root mean square of the remaining distances
  double spread = 0.0;  ///< mm, weighted RMS extent of `from` along its second principal axis:
                        ///< near 0 for fewer than three points and for points on one line, whose
                        ///< rotation is not determined

  Eigen::Vector3d apply(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
  Eigen::Vector3d undo(const Eigen::Vector3d& point) const {
    return rotation.transpose() * (point - translation);
  }
};

/// Minimises Σ wᵢ ‖R fromᵢ + t − toᵢ‖² over proper rotations R and translations t (Kabsch 1976,
/// 1978, by singular value decomposition). `weights` is empty (all 1) or as long as the points,
/// not negative. Without any weight the result is the identity.
RigidFit fit_rigid(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                   std::span<const double> weights = {});

}  // namespace kinemesh
