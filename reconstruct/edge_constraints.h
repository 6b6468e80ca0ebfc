// Edges that the user asks for or forbids.
#pragma once

#include <vector>

#include "reconstruct/edit_mesh.h"

namespace kinemesh {

/// Constraints between vertices, the smaller one first in each edge.
struct EdgeConstraints {
  std::vector<DirectedEdge> edges;     ///< must be there
  std::vector<DirectedEdge> no_edges;  ///< must not be there
  bool empty() const { return edges.empty() && no_edges.empty(); }
  bool forces(VertexIndex a, VertexIndex b) const;
};

/// Joins a and b by flipping the edges between them (Sloan, Advances in Engineering Software 17,
/// 1993), seen along the mean normal at both. False, and no change, where the way leaves the
/// mesh or meets an edge of `keep`.
bool force_edge(EditMesh& mesh, const Points& points, VertexIndex a, VertexIndex b,
                const std::vector<DirectedEdge>& keep = {});

/// Removes the edge a–b: flips it, or takes the face off when it lies on the boundary and its third
/// corner does not. False, and no change, when neither is possible.
bool remove_edge(EditMesh& mesh, VertexIndex a, VertexIndex b);

/// Establishes all constraints; returns those that cannot be met.
EdgeConstraints apply_constraints(EditMesh& mesh, const Points& points,
                                  const EdgeConstraints& constraints);

}  // namespace kinemesh
