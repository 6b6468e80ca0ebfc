// The two constructions taken from CGAL (GPL parts: see docs/dependencies.md), behind plain types.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reconstruct/edit_mesh.h"

namespace kinemesh {

/// Advancing front surface reconstruction (Cohen-Steiner and Da, The Visual Computer 20, 2004):
/// triangles of the 3D Delaunay triangulation, most plausible first, none with an edge a–b longer
/// than edge_bound(a, b). Edge-manifold and consistently oriented, with either side up; markers
/// may be left out, and there may be several components. Fewer than four points, or points on a
/// plane, give none.
std::vector<Triangle> advancing_front(const Points& points,
                                      const std::vector<double>& edge_bound_of_vertex);

/// Delaunay triangulation of points in the plane, counter-clockwise; points at the same place are
/// left out but for one.
std::vector<Triangle> planar_delaunay(const std::vector<Eigen::Vector2d>& points);

}  // namespace kinemesh
