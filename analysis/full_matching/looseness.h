// How loosely each place of a map is held: how far it drifts when the surface may stretch more, or
// less. Private to analysis/.
//
// Where shape and motion tell the place, it stays; where the map only follows its surroundings, it
// gives way. Unlike differences of signals this also sees where nothing is told (neck, temples).
#pragma once

#include <vector>

#include "analysis/full_matching/composed_map.h"

namespace kinemesh::full_matching {

/// Per vertex of the closed surface A, in √area: the geometric mean of how far it drifts on B.
/// `map` must be finished, its weights being `weights` and `keep_shape`; it is collapsed and moved.
std::vector<double> looseness_of(ComposedMap& map, const ClosedSurface& closed,
                                 const Signal& weights, double keep_shape, const RunContext& ctx);

/// Means over each vertex and its neighbours, `rounds` times.
std::vector<double> smoothed(std::vector<double> values, const Topology& topology, int rounds);

}  // namespace kinemesh::full_matching
