// A pose and an order of the markers that depend on their shape alone, so that the triangulation
// is the same wherever the subject stands and in whatever order the markers come.
#pragma once

#include <vector>

#include "reconstruct/edit_mesh.h"

namespace kinemesh {

struct CanonicalPose {
  /// Points in canonical pose and order: centroid at 0, principal axes on x, y, z, the heavier
  /// tail of the cloud towards +x and +y. Moved by a smooth field of at most 1e-4 of the spread,
  /// a function of the place alone, so that symmetric clouds have no ties.
  Points points;
  std::vector<VertexIndex> original;  ///< index of each in the input
};

CanonicalPose canonical_pose(const Points& points);

}  // namespace kinemesh
