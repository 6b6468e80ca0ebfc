// Follows a shortest path back from where it arrived. Internal to mesh/geodesics.
#pragma once

#include <vector>

#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/unfolded_mesh.h"

namespace kinemesh::geodesics {

/// Walks straight from `start`, a point in the frame of `arrival.halfedge`, to its unfolded origin,
/// and appends where it crosses edges, and the origin at last. The origin is `vertex` (inner
/// index), or the point `origin` of the original mesh where `vertex` is invalid_index. Returns
/// false when it does not turn up where it should be.
bool trace_straight(const UnfoldedMesh& mesh, const Eigen::Vector2d& start,
                    const GeodesicArrival& arrival, const SurfacePoint& origin, VertexIndex vertex,
                    std::vector<SurfacePoint>& points);

}  // namespace kinemesh::geodesics
