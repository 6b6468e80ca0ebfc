// Fuzz targets of what stands on the C3D reader: lint and repair, and the tables of other programs.
#pragma once

#include <vector>

#include "tests/fuzz/target.h"

namespace kinemesh::fuzz {

/// `c3d_seeds` are those of the reader's own target.
std::vector<Target> session_targets(const std::function<std::vector<Seed>()>& c3d_seeds);

}  // namespace kinemesh::fuzz
