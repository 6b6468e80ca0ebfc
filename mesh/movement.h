// How much each vertex moves beside the motion of the whole body.
#pragma once

#include <vector>

#include "config/run_context.h"
#include "mesh/animated_mesh.h"

namespace kinemesh {

/// Per vertex, mm: root mean square distance over all frames from the mean shape, after each
/// frame's rigid motion is taken out (Kabsch 1976). 0 for fewer than two frames.
std::vector<double> movement_of(const AnimatedMesh& mesh, const RunContext& ctx = {});

}  // namespace kinemesh
