// Frames to which a surface jumps: between two cuts of a recording, or where a reader or a solver
// went wrong. Deformation there outweighs that of all other frames.
#pragma once

#include <cstddef>
#include <vector>

#include "config/run_context.h"
#include "mesh/animated_mesh.h"

namespace kinemesh {

/// Frames to which the vertices move by more than a quarter of the bounding box's diagonal and more
/// than twenty times as far as they mostly do from frame to frame, both on average over the
/// vertices. Ascending, 0-based; positions that are not finite do not count.
std::vector<std::size_t> jumping_frames(const AnimatedMesh& animation);

/// Warns of them with their numbers.
void warn_of_jumps(const AnimatedMesh& animation, const RunContext& ctx);

}  // namespace kinemesh
