// Intrinsic Delaunay triangulation: edges flipped on the surface, not in space, until no angle sum
// opposite an edge exceeds π (Bobenko & Springborn 2007; data as in Sharp, Soliman & Crane 2019).
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

/// Triangles by their vertices and edge lengths alone. Vertices keep their indices. Several edges
/// may join the same two vertices, and an edge may join a vertex to itself.
struct IntrinsicTriangulation {
  std::vector<Triangle> faces;
  std::vector<std::array<double, 3>> lengths;  ///< [f][c]: of the edge from corner c to the next
  std::size_t flips = 0;
};

/// Throws InputError as intrinsic_lengths does. Borders and non-manifold edges stay.
IntrinsicTriangulation intrinsic_delaunay(const Topology& topology,
                                          std::span<const Eigen::Vector3d> positions);

}  // namespace kinemesh
