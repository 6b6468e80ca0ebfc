// Constraints as the user names them, by marker.
#pragma once

#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "reconstruct/edge_constraints.h"

namespace kinemesh {

/// Marker indices of "A:B" texts; labels may hold colons themselves. Throws UsageError for a text
/// that does not name two markers of the take.
EdgeConstraints named_constraints(const MarkerSequence& take, const std::vector<std::string>& edges,
                                  const std::vector<std::string>& no_edges);

/// The same with vertex v named position[v].
EdgeConstraints renumbered(EdgeConstraints constraints, const std::vector<VertexIndex>& position);

/// Throws UsageError naming the markers of the first constraint in `unmet` (marker indices).
void refuse_unmet(const EdgeConstraints& unmet, const MarkerSequence& take);

}  // namespace kinemesh
