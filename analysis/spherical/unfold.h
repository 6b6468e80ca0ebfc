// A collapsed mesh on the sphere, laid out anew where its larger triangles fold. Private to
// analysis/.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis/spherical/ring_mesh.h"
#include "config/run_context.h"

namespace kinemesh::spherical {

/// The rotation that brings `from` nearest to `to` on average, both on the unit sphere (Kabsch
/// 1976).
Eigen::Matrix3d nearest_rotation(std::span<const Eigen::Vector3d> from,
                                 std::span<const Eigen::Vector3d> to);

/// Where a triangle of the present mesh is turned over, its vertices are mapped to the sphere anew
/// (map_to_sphere) and turned to lie near where they were. Throws NoResultError as map_to_sphere.
void unfold(const RingMesh& mesh, std::span<const Eigen::Vector3d> rest,
            std::vector<Eigen::Vector3d>& points, const RunContext& ctx);

}  // namespace kinemesh::spherical
