// The connectivity that generated meshes of the benchmarks share.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

/// `side` × `side` vertices in rows, two triangles a cell.
inline std::vector<Triangle> grid_faces(uint32_t side) {
  std::vector<Triangle> faces;
  for (uint32_t r = 0; r + 1 < side; ++r) {
    for (uint32_t c = 0; c + 1 < side; ++c) {
      const uint32_t v = r * side + c;
      faces.push_back({v, v + 1, v + side});
      faces.push_back({v + 1, v + side + 1, v + side});
    }
  }
  return faces;
}

}  // namespace kinemesh
