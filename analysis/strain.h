// The kernels of strain and curvature over a block of frames. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis/deformation.h"
#include "analysis/surface_balls.h"
#include "mesh/topology.h"

namespace kinemesh::strain {

/// Positions of a block of frames: vertices × 3 × stride floats, the frames side by side.
struct Block {
  std::size_t stride = 0;  ///< frames of the block
  std::vector<float> positions;
  const float* row(std::size_t vertex, std::size_t axis) const {
    return positions.data() + (3 * vertex + axis) * stride;
  }
};

/// Per vertex the linear map from the positions around it to F: column a of F is Σ_j
/// weights[2 j + a] · x_j; FᵀF = 1 in the rest pose.
struct Stencils {
  VertexLists lists;
  std::vector<float> weights;          ///< two per item
  std::vector<Eigen::Vector3f> basis;  ///< two per vertex: the rest directions of a = 0, 1
};
Stencils make_stencils(const Topology& topology, std::span<const Eigen::Vector3d> rest,
                       VertexLists lists, const RunContext& ctx);

/// A row of FᵀF: c00, c01, c11, each `frames` floats.
void stretch_of_vertex(const Stencils& stencils, const Block& block, std::size_t vertex,
                       float* tensor);
/// Strain of a row of tensors.
void measure_row(const float* tensor, std::size_t frames, StrainMeasure measure, float floor,
                 float* out);

/// Per triangle: the inverse of its rest edges in its plane (row-major 2 × 2), `valid` where it
/// has area.
struct RestTriangles {
  std::vector<std::array<float, 4>> inverse;
  std::vector<uint8_t> valid;
  std::size_t degenerate = 0;
};
RestTriangles rest_triangles(const Topology& topology, std::span<const Eigen::Vector3d> rest);
void stretch_of_face(const RestTriangles& rest, const Topology& topology, const Block& block,
                     std::size_t face, float* tensor);

/// Half of what the inner edges at each vertex contribute: dihedral angle × length (mm), and the
/// area that belongs to them (mm²): vertices × stride floats each. Summed over a ball, an edge
/// counts by half for each end inside, so that no direction is left out at the rim.
void bend_at_vertices(const Topology& topology, const Block& block, std::vector<float>& bend,
                      std::vector<float>& area, const RunContext& ctx);

}  // namespace kinemesh::strain
