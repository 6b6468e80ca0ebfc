// The histogram of AnimMeshHoG. Private to analysis/; see descriptors.h.
#pragma once

#include <vector>

#include "analysis/deformation.h"
#include "analysis/feature.h"

namespace kinemesh {

class AnimMeshHog {
 public:
  /// Keeps references.
  AnimMeshHog(const AnimatedMesh& animation, const DeformationResult& deformation, double patch);
  /// 8 × 4 × 8 values with sum 1; all 0 where nothing changes around the feature.
  std::vector<float> histogram(const Feature& feature) const;

 private:
  struct Patch;
  struct Moments;
  Patch make_patch(const Feature& feature) const;
  void flatten(Patch& patch) const;
  void align(Patch& patch, std::size_t frame) const;
  Eigen::MatrixXd volume_of(const Patch& patch, const Feature& feature,
                            const Moments& moments) const;

  const AnimatedMesh& animation_;
  const DeformationResult& deformation_;
  double patch_;
  std::vector<Eigen::Vector3d> normals_;
};

}  // namespace kinemesh
