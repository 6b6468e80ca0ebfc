// Flips edges until the mesh is Delaunay on the surface that its vertices suggest.
#pragma once

#include <cstddef>
#include <vector>

#include "config/run_context.h"
#include "reconstruct/edit_mesh.h"

namespace kinemesh {

/// Mean of the face normals around each vertex, weighted by angle, unit length (0 without faces).
Points vertex_normals(const EditMesh& mesh, const Points& points);

/// Length of the surface curve between two markers, mm: of the cubic through both that is normal
/// to both normals, to second order in the slopes, at most 1.6 × the chord.
double arc_length(const Eigen::Vector3d& p, const Eigen::Vector3d& normal_p,
                  const Eigen::Vector3d& q, const Eigen::Vector3d& normal_q);

/// Flips every inner edge whose opposite angles, in triangles with the arc lengths of their edges,
/// sum to more than those of the other diagonal; the largest gain first. Edges in `keep` (smaller
/// vertex first) stay, edges in `avoid` are never made. Returns the number of flips.
std::size_t flip_to_delaunay(EditMesh& mesh, const Points& points,
                             const std::vector<DirectedEdge>& keep = {},
                             const std::vector<DirectedEdge>& avoid = {},
                             const RunContext& ctx = {});

}  // namespace kinemesh
