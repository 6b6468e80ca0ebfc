// The triangulation of another take of the same subject, used again by marker name.
#pragma once

#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/run_context.h"
#include "mesh/mesh.h"
#include "reconstruct/triangulate.h"

namespace kinemesh {

struct ReuseResult {
  TriangulateResult triangulation;  ///< vertex i is marker i of the take
  std::vector<std::string>
      missing;  ///< vertices of the previous mesh that the take has no marker for
  std::vector<std::string> added;  ///< markers of the take that the previous mesh has no vertex for
};

/// Every vertex of `previous` whose name is a label of the take (alone or as "subject:label")
/// keeps its edges. Where a marker is missing, its neighbours are joined around the hole; a new
/// marker is inserted where it lies in the reference frame; only edges about those places are
/// flipped to Delaunay. Openings stay open and are named by where they lie. The frame and the
/// constraints of `options` hold; its search for openings and its bounds are not used.
/// Throws InputError when the previous mesh has no vertex names or is no manifold, NoResultError
/// when fewer than three markers, or less than half of the vertices, are found again.
ReuseResult reuse_topology(const Mesh& previous, const MarkerSequence& take,
                           const TriangulateOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
