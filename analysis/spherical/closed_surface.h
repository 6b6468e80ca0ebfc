// Holes of an open surface closed for a map to the sphere: every boundary loop gets a filling of
// graded rings of new vertices down to one in the middle, whose triangles have a bounded aspect.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

struct ClosedSurface {
  /// Vertices and faces of the open surface first, with their numbers; those of fillings follow.
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> positions;
  std::size_t surface_vertices = 0, surface_faces = 0;
  bool filling_face(FaceIndex f) const { return f >= surface_faces; }
  bool filling_vertex(VertexIndex v) const { return v >= surface_vertices; }
  /// The holes as boundary loops of the open surface, in its order.
  std::vector<std::vector<VertexIndex>> loops;
};

/// Throws NoResultError naming reason and remedy for a surface that is not one manifold piece or
/// has handles.
ClosedSurface close_holes(const Topology& topology, std::span<const Eigen::Vector3d> positions);

}  // namespace kinemesh
