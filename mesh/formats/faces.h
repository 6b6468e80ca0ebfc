// Collecting the faces of a file: triangles as they are, polygons cut into triangles at the end,
// when all positions are known.
//
// A polygon that is convex in its mean plane becomes a fan from its first corner. Others are cut by
// ear clipping in that plane (smallest corner index first), so concave ones keep their shape; what
// cannot be cut that way (self-crossing ones) and polygons of over 1,000 corners become a fan.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/formats/mesh_data.h"

namespace kinemesh {

class FaceCollector {
 public:
  void reserve(std::size_t faces) { triangles_.reserve(faces); }
  std::size_t size() const { return triangles_.size() + polygons_.size(); }
  void add(const Triangle& triangle) { triangles_.push_back(triangle); }
  /// Faces of fewer than three corners count as left out.
  void add(std::span<const VertexIndex> corners);
  std::span<Triangle> grow(std::size_t count) {
    triangles_.resize(triangles_.size() + count);
    return {triangles_.data() + triangles_.size() - count, count};
  }

  /// Gives up the last `count` triangles of grow().
  void shrink(std::size_t count) { triangles_.resize(triangles_.size() - count); }
  /// Position in order of addition of the first face with a corner that is not below
  /// `vertex_count`, or size() when all are.
  std::size_t first_out_of_range(std::size_t vertex_count) const;
  /// Moves the faces, in order, into `data`, whose positions are there. Every corner must be in
  /// range.
  void finish(MeshData& data);

 private:
  struct Polygon {
    std::size_t before;       ///< number of triangles added before it
    std::size_t begin, size;  ///< its corners in corners_
  };
  std::vector<Triangle> triangles_;
  std::vector<Polygon> polygons_;
  std::vector<VertexIndex> corners_;
  std::size_t dropped_ = 0;
};

/// Triangles of one polygon; `positions` are vertices × 3.
void triangulate_polygon(std::span<const VertexIndex> corners, const float* positions,
                         std::vector<Triangle>& out);

}  // namespace kinemesh
