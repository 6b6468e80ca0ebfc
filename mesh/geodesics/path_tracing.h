// Follows a shortest path back from where it arrived. Internal to mesh/geodesics.
#pragma once

#include <array>
#include <vector>

#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/unfolded_mesh.h"

namespace kinemesh::geodesics {

struct TraceEnd {
  bool at_origin = false;
  /// Else: a vertex that the path passes, or (when `lost`) the corners of the face where the way
  /// went wrong by rounding, in a mesh with nearly degenerate triangles.
  std::array<VertexIndex, 3> vertices{invalid_index, invalid_index, invalid_index};
  bool lost = false;
};

/// Walks straight from `start`, a point in the frame of `arrival.halfedge`, to its unfolded origin,
/// and appends where it crosses edges, and the origin at last. The origin is `vertex` (inner
/// index), or the point `origin` of the original mesh where `vertex` is invalid_index. Ends before
/// at a vertex that lies on the way: its own arrival leads on.
TraceEnd trace_straight(const UnfoldedMesh& mesh, const Eigen::Vector2d& start,
                        const GeodesicArrival& arrival, const SurfacePoint& origin,
                        VertexIndex vertex, std::vector<SurfacePoint>& points);

}  // namespace kinemesh::geodesics
