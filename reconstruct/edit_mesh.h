// A triangle mesh that can be edited face by face: the scratch pad of the triangulation. Always
// edge-manifold and consistently oriented; a face that would break this is refused.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

/// Vertex positions of a static mesh, mm.
using Points = std::vector<Eigen::Vector3d>;
/// A directed edge.
using DirectedEdge = std::array<VertexIndex, 2>;
/// The edge with its lesser vertex first, so that both directions are one.
inline DirectedEdge undirected(VertexIndex a, VertexIndex b) {
  return {std::min(a, b), std::max(a, b)};
}

class EditMesh {
 public:
  explicit EditMesh(std::size_t vertex_count) : out_(vertex_count) {}
  /// Faces of `triangles` in order; those that would break the manifold edges are left out.
  EditMesh(std::size_t vertex_count, const std::vector<Triangle>& triangles);

  std::size_t vertex_count() const { return out_.size(); }
  std::size_t face_count() const { return face_count_; }
  bool has_vertex(VertexIndex v) const { return !out_[v].empty(); }

  /// The corner opposite the directed edge from → to in its face; invalid_index without a face.
  VertexIndex opposite(VertexIndex from, VertexIndex to) const;
  bool has_halfedge(VertexIndex from, VertexIndex to) const {
    return opposite(from, to) != invalid_index;
  }
  /// The edge is in the mesh, in either direction.
  bool has_edge(VertexIndex a, VertexIndex b) const {
    return has_halfedge(a, b) || has_halfedge(b, a);
  }
  bool is_boundary_edge(VertexIndex a, VertexIndex b) const {
    return has_halfedge(a, b) != has_halfedge(b, a);
  }
  bool is_boundary_vertex(VertexIndex v) const;
  /// The fans of faces around v are one (true for a vertex without faces).
  bool has_one_fan(VertexIndex v) const;

  /// False, and no change, when a directed edge of the face is taken or two corners are the same.
  bool add_face(VertexIndex a, VertexIndex b, VertexIndex c);
  /// Removes the face on the left of from → to, which must exist.
  void remove_face(VertexIndex from, VertexIndex to);
  /// Replaces the inner edge a–b by the one between the two corners opposite to it. False, and no
  /// change, when a–b is no inner edge or the other diagonal exists already.
  bool flip(VertexIndex a, VertexIndex b);
  void reverse_orientation();

  /// Corners of the faces of v, in no particular order: (next, previous) of each face.
  struct Corner {
    VertexIndex next, previous;
  };
  const std::vector<Corner>& corners(VertexIndex v) const { return out_[v]; }
  /// Vertices joined to v by an edge, ascending.
  std::vector<VertexIndex> neighbours(VertexIndex v) const;

  /// Every face once, its smallest vertex first, ascending: independent of the history of edits.
  std::vector<Triangle> triangles() const;
  /// Every edge once, ascending, in the direction in which it has a face (a < b when both have).
  std::vector<DirectedEdge> edges() const;
  /// Boundary loops in the direction of their halfedges, each from its smallest vertex on.
  std::vector<std::vector<VertexIndex>> boundary_loops() const;
  /// V − E + F over vertices that have faces.
  int64_t euler_characteristic() const;

 private:
  std::vector<std::vector<Corner>> out_;
  std::size_t face_count_ = 0;
};

}  // namespace kinemesh
