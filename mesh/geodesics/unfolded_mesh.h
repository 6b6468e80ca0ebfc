// A triangle mesh prepared for unfolding: for every halfedge the planar frame of the triangle
// beyond it, and around every vertex the angles of its corners. Internal to mesh/geodesics.
//
// Frame of halfedge h = (v1 → v2) of face f: v1 at (0, 0), v2 at (length, 0), the third vertex v3
// at (px, py) with py > 0. What enters f through h comes from y < 0. Faces and vertices are
// renumbered along a space-filling curve, so that what is near on the surface is near in memory.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mesh/geodesics/intrinsic_lengths.h"
#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh::geodesics {

/// One of the two sides of a triangle that lead to v3.
struct FrameSide {
  double cos, sin;  // of the angle between the side and v1 v2
  double length;
};

/// An edge, once, with its ends.
struct Edge {
  double length;
  std::array<VertexIndex, 2> ends;
};

struct alignas(32) Frame {
  double length;
  double px, py;                        // v3
  std::array<FrameSide, 2> sides;       // v1 v3 (left) and v2 v3 (right)
  std::array<HalfedgeIndex, 2> beyond;  // twins of v3 → v1 and v2 → v3: what leaves f over a side
                                        // enters the next face through them
  std::array<VertexIndex, 2> ends;  // v1, v2
  VertexIndex apex;                 // v3
};

enum class VertexKind : uint8_t {
  convex,     // inner vertex with an angle below 2π: no shortest path passes through it
  flat,       // inner vertex with an angle of 2π or so little less that paths pass right beside it
  saddle,     // inner vertex with an angle above 2π
  boundary,   // one open fan of faces
  irregular,  // several fans (non-manifold), or all but at the place of another vertex: paths may
              // pass it in any direction
};

class UnfoldedMesh {
 public:
  /// Throws InputError as intrinsic_lengths does.
  UnfoldedMesh(const Topology& topology, std::span<const Eigen::Vector3d> positions);

  std::size_t vertex_count() const { return kinds_.size(); }
  std::size_t face_count() const { return frames_.size() / 3; }
  const Frame& frame(HalfedgeIndex h) const { return frames_[h]; }
  /// Starts loading the frame of h, which may be invalid_index.
  void prefetch(HalfedgeIndex h) const {
    if (h == invalid_index) return;
    __builtin_prefetch(&frames_[h]);
    __builtin_prefetch(&frames_[h].beyond);
  }
  HalfedgeIndex twin(HalfedgeIndex h) const { return twins_[h]; }
  VertexKind kind(VertexIndex v) const { return kinds_[v]; }
  /// Angle at the vertex v1 of h at which its corner begins, counter-clockwise around v1.
  double corner_start(HalfedgeIndex h) const { return corner_starts_[h]; }
  double corner_angle(HalfedgeIndex h) const { return corner_angles_[h]; }
  double total_angle(VertexIndex v) const { return total_angles_[v]; }
  /// An outgoing halfedge; the first of the fan at a boundary; invalid_index without faces.
  HalfedgeIndex outgoing(VertexIndex v) const { return outgoing_[v]; }
  /// Every outgoing halfedge of an irregular vertex.
  const std::vector<HalfedgeIndex>& corners_of_irregular(VertexIndex v) const {
    return irregular_corners_.at(v);
  }

  /// Every edge of every face once; where more than two faces meet, or two that face opposite ways,
  /// once for each face.
  const std::vector<Edge>& edges() const { return edges_; }

  double mean_length() const { return mean_length_; }
  std::size_t degenerate_faces() const { return degenerate_faces_; }

  /// Numbering: internal index of an original one and back. Corners keep their order.
  VertexIndex inner_vertex(VertexIndex original) const { return inner_vertices_[original]; }
  VertexIndex original_vertex(VertexIndex inner) const { return original_vertices_[inner]; }
  FaceIndex inner_face(FaceIndex original) const { return inner_faces_[original]; }
  FaceIndex original_face(FaceIndex inner) const { return original_faces_[inner]; }

  /// The point with these weights at the corners 0, 1, 2 of the face of h, in the frame of h.
  Eigen::Vector2d in_frame(HalfedgeIndex h, const std::array<double, 3>& weights) const;
  /// The reverse: a point of the original mesh.
  SurfacePoint to_surface_point(HalfedgeIndex h, const Eigen::Vector2d& point) const;
  /// A vertex (inner index, with faces) as a point of the original mesh.
  SurfacePoint vertex_point(VertexIndex v) const;

 private:
  void renumber(const Topology& topology, std::span<const Eigen::Vector3d> positions);
  void build_frames(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                    const IntrinsicLengths& intrinsic);
  void build_fans();
  void list_irregular_corners();
  void list_edges();

  std::vector<Frame> frames_;
  std::vector<HalfedgeIndex> twins_;
  std::vector<double> corner_starts_, corner_angles_, total_angles_;
  std::vector<HalfedgeIndex> outgoing_;
  std::vector<VertexKind> kinds_;
  std::unordered_map<VertexIndex, std::vector<HalfedgeIndex>> irregular_corners_;
  std::vector<Edge> edges_;
  std::vector<VertexIndex> inner_vertices_, original_vertices_;
  std::vector<FaceIndex> inner_faces_, original_faces_;
  double mean_length_ = 0.0;
  std::size_t degenerate_faces_ = 0;
};

}  // namespace kinemesh::geodesics
