// B's rest surface brought onto A's, and its signed distance from it. Private to
// analysis/comparison.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/comparison/comparison.h"

namespace kinemesh::comparison {

struct ShapeFit {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  double scale = 1.0;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const { return scale * (turn * p) + shift; }
};

/// Least squares over corresponding places, weighted by A's areas and confidence (Umeyama 1991).
ShapeFit fit_shape(const Comparison& c, const Topology& topology_b, bool with_scale);

/// From each vertex of A to the nearest point of B's surface, positive outside A; NaN where A's
/// vertex has no counterpart.
std::vector<float> signed_distances(const Comparison& c, const Topology& topology_a,
                                    const Topology& topology_b, const ShapeFit& fit);

}  // namespace kinemesh::comparison
