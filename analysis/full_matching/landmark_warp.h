// Landmarks moved to where they must lie on the sphere, the vertices around them giving way, by
// steps that adapt (after Mykhalchuk 2015, 5.6). Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis/spherical/ring_mesh.h"
#include "config/run_context.h"
#include "mesh/surface_point.h"

namespace kinemesh::full_matching {

/// A vertex of A, and where it must come to lie.
struct Anchor {
  VertexIndex vertex = invalid_index;
  SurfacePoint place;    ///< on B
  Eigen::Vector3d goal;  ///< the same on B's sphere
};

/// Moves the anchors' points towards their goals and all others of the mesh to even out what that
/// distorts. No step turns over a triangle. Returns the anchors that did not arrive, by index.
std::vector<std::size_t> warp_to_anchors(const spherical::RingMesh& mesh,
                                         std::span<const Eigen::Vector3d> rest,
                                         std::vector<Eigen::Vector3d>& points,
                                         std::span<const Anchor> anchors, const RunContext& ctx);

}  // namespace kinemesh::full_matching
