// What triangulate() and reuse_topology() say about the mesh they made.
#pragma once

#include <vector>

#include "capture/marker_sequence.h"
#include "reconstruct/reference_frame.h"
#include "reconstruct/triangulate.h"

namespace kinemesh {

/// Sets reference frame, openings and the diagnostics that follow from the topology, which must be
/// there; `cut` names the openings that were cut, by one vertex of each loop. Other loops but the
/// rim, the longest one, are gaps.
void describe_result(TriangulateResult& result, const MarkerSequence& take,
                     const ReferenceFrame& reference, double spacing,
                     const std::vector<Opening>& cut);

double perimeter(const std::vector<VertexIndex>& loop, const Points& points);

}  // namespace kinemesh
