// The immutable connectivity of a triangle mesh, with its adjacency built once.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kinemesh {

using VertexIndex = uint32_t;
using FaceIndex = uint32_t;
/// Halfedge h = 3 * face + corner runs from corner `h % 3` of its face to the next corner.
using HalfedgeIndex = uint32_t;
inline constexpr uint32_t invalid_index = 0xFFFFFFFFU;

/// A triangle's vertices, 0-based, counter-clockwise seen from outside.
using Triangle = std::array<VertexIndex, 3>;

/// An undirected edge with its two halfedges; `right` is invalid_index on a boundary.
struct Edge {
  std::array<VertexIndex, 2> vertices;  ///< ends of `left`, in its direction
  HalfedgeIndex left = invalid_index;
  HalfedgeIndex right = invalid_index;
  bool boundary() const { return right == invalid_index; }
};

class Topology {
 public:
  /// Takes any triangles whose indices are below `vertex_count`, non-manifold ones included.
  /// Throws InputError naming the face for an index out of range or a face that repeats a vertex.
  Topology(std::size_t vertex_count, std::vector<Triangle> faces);

  static std::shared_ptr<const Topology> create(std::size_t vertex_count,
                                                std::vector<Triangle> faces) {
    return std::make_shared<const Topology>(vertex_count, std::move(faces));
  }

  std::size_t vertex_count() const { return vertex_count_; }
  std::size_t face_count() const { return faces_.size(); }
  std::size_t edge_count() const { return edges_.size(); }
  const std::vector<Triangle>& faces() const { return faces_; }
  /// Each undirected edge once, in order of its first halfedge. An edge with more than two faces,
  /// or with two faces of opposite orientation, appears once for every unpaired halfedge.
  const std::vector<Edge>& edges() const { return edges_; }

  VertexIndex from(HalfedgeIndex h) const { return faces_[h / 3][h % 3]; }
  VertexIndex to(HalfedgeIndex h) const { return from(next(h)); }
  static HalfedgeIndex next(HalfedgeIndex h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static HalfedgeIndex previous(HalfedgeIndex h) { return h % 3 == 0 ? h + 2 : h - 1; }
  /// The opposite halfedge, or invalid_index on a boundary or at a non-manifold edge.
  HalfedgeIndex twin(HalfedgeIndex h) const { return twins_[h]; }

  /// Faces around a vertex, ascending.
  std::span<const FaceIndex> faces_of(VertexIndex v) const {
    return {face_list_.data() + face_offsets_[v], face_list_.data() + face_offsets_[v + 1]};
  }
  /// Vertices that share an edge with v, ascending, without v.
  std::span<const VertexIndex> neighbours_of(VertexIndex v) const {
    return {neighbour_list_.data() + neighbour_offsets_[v],
            neighbour_list_.data() + neighbour_offsets_[v + 1]};
  }

  bool is_boundary_vertex(VertexIndex v) const { return boundary_vertex_[v]; }

  /// Boundary loops as vertices in the direction of their halfedges (the surface on the left).
  /// Loops that touch at a vertex are separated there.
  const std::vector<std::vector<VertexIndex>>& boundary_loops() const { return loops_; }

  /// Connected components of the faces, counted over edges; vertices without faces count as none.
  std::size_t component_count() const { return component_count_; }
  /// Vertices that belong to no face.
  std::size_t isolated_vertex_count() const { return isolated_count_; }
  /// V − E + F over the vertices that have faces.
  int64_t euler_characteristic() const;
  /// Every edge has one or two faces, every vertex one fan of faces, orientation is consistent.
  bool is_manifold() const { return manifold_; }

  friend bool operator==(const Topology& a, const Topology& b) {
    return a.vertex_count_ == b.vertex_count_ && a.faces_ == b.faces_;
  }

 private:
  void pair_halfedges();
  void build_rings();
  void trace_boundaries();
  void count_components();
  bool vertices_have_one_fan() const;

  std::size_t vertex_count_ = 0;
  std::vector<Triangle> faces_;
  std::vector<HalfedgeIndex> twins_;
  std::vector<Edge> edges_;
  std::vector<uint32_t> face_offsets_, neighbour_offsets_;
  std::vector<FaceIndex> face_list_;
  std::vector<VertexIndex> neighbour_list_;
  std::vector<bool> boundary_vertex_;
  std::vector<std::vector<VertexIndex>> loops_;
  std::size_t component_count_ = 0;
  std::size_t isolated_count_ = 0;
  std::size_t distinct_edges_ = 0;
  bool manifold_ = true;
};

}  // namespace kinemesh
