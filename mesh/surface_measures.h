// Areas, normals and lengths of a surface in one pose.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

/// A third of the area of the faces around each vertex, mm².
std::vector<double> vertex_areas(const Topology& topology,
                                 std::span<const Eigen::Vector3d> positions);
/// Unit normals of the vertices, weighed by area; zero where the faces around one have no area.
std::vector<Eigen::Vector3d> vertex_normals(const Topology& topology,
                                            std::span<const Eigen::Vector3d> positions);
/// Mean length of the edges, mm; 0 without edges.
double mean_edge_length(const Topology& topology, std::span<const Eigen::Vector3d> positions);
/// Diagonal of the bounding box of the vertices that have faces, mm.
double bounding_diagonal(const Topology& topology, std::span<const Eigen::Vector3d> positions);

}  // namespace kinemesh
