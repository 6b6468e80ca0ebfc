// Shortest paths along edges. Internal to mesh/geodesics.
#pragma once

#include <span>

#include "config/run_context.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/unfolded_mesh.h"

namespace kinemesh::geodesics {

struct EdgePaths {
  std::vector<double> distances;          ///< by inner vertex
  std::vector<GeodesicArrival> arrivals;  ///< origin: the vertex before, or count + source
};

/// Sources inside a face reach its corners straight. Points and vertices by inner index.
EdgePaths dijkstra(const UnfoldedMesh& mesh, std::span<const SurfacePoint> sources, double radius,
                   const RunContext& ctx);

}  // namespace kinemesh::geodesics
