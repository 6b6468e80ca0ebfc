// The rotation of one sphere onto another with which a matching starts. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis/full_matching/composed_map.h"

namespace kinemesh::full_matching {

/// Weights of the signals' disagreement when rotations are compared.
struct RotationWeights {
  double strain = 1.0, normals = 1.0, loops = 2.0, shape = 4.0, landmarks = 20.0;
};

/// Tries `count` rotations spread evenly and refines the best of them: least difference of strain,
/// loops, normals and of the positions after the best similarity without reflection, and least
/// distance on the sphere of the landmarks from their goals.
Eigen::Matrix3d start_rotation(const SurfaceSignals& source,
                               std::span<const Eigen::Vector3d> sphere, const Target& target,
                               std::span<const Anchor> anchors, int count,
                               const RotationWeights& weights, const RunContext& ctx);

}  // namespace kinemesh::full_matching
