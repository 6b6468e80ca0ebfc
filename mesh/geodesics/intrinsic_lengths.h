// Edge lengths of a triangle mesh under which every triangle has an area: lengths as they are for
// sound triangles, and the least lengthening that mends degenerate ones ("intrinsic
// mollification", Sharp & Crane 2020, section 4.5; here local instead of global).
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

struct IntrinsicLengths {
  std::vector<double> lengths;  ///< one per halfedge, twins alike, in the units of the positions
  std::vector<bool> changed_faces;   ///< one per face: an edge of it was lengthened
  std::size_t degenerate_faces = 0;  ///< faces that had no area
  double largest_change = 0.0;       ///< how much the most lengthened edge grew
  double mean_length = 0.0;          ///< over halfedges
  double longest = 0.0;
};

/// A triangle counts as degenerate when its height over its longest edge is below
/// `least_height` times that edge. The shorter edges of degenerate triangles are lengthened until
/// short + short ≥ long + slack, with slack = `relative_slack` × the longest edge: neighbouring
/// triangles agree on every edge, and sound triangles far from degenerate ones stay untouched.
/// Throws InputError naming the vertex when a position used by a face is not finite, or when all
/// vertices lie at the same place.
IntrinsicLengths intrinsic_lengths(const Topology& topology,
                                   std::span<const Eigen::Vector3d> positions,
                                   double least_height = 1e-8, double relative_slack = 1e-12);

/// Twice the area of a triangle from its edge lengths, stable for slivers (Kahan); 0 when the
/// lengths form no triangle.
double double_area(double a, double b, double c);

}  // namespace kinemesh
