// The closed form of the synthetic face: a point of the surface for domain coordinates, the side
// of the slit, the subject's proportions and the expression.
#pragma once

#include <Eigen/Core>

#include "tests/support/synthetic_face.h"

namespace kinemesh::test {

/// The surface point at (u, v). `side` is +1 above and -1 below the slit of its row of features
/// (mouth below v = 0, lids above); it matters only close to a slit.
Eigen::Vector3d face_point(const FaceShape& shape, const Eigen::Vector2d& domain, int side,
                           const ExpressionWeights& weights);

}  // namespace kinemesh::test
