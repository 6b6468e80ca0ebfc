// The readers of the mesh formats as fuzz targets.
#pragma once

#include <vector>

#include "tests/fuzz/target.h"

namespace kinemesh::fuzz {

std::vector<Target> mesh_targets();

}  // namespace kinemesh::fuzz
