// Both faces side by side in 3D, with the fields of a comparison. Private to analysis/comparison.
#pragma once

#include <utility>

#include "analysis/comparison/comparison_report.h"
#include "report/html/mesh_viewer.h"

namespace kinemesh::comparison {

/// They turn and play together, B in A's time and turned as A, coloured on common scales.
std::pair<MeshViewer, MeshViewer> viewers_of(const ComparisonStory& story, const RunContext& ctx);

}  // namespace kinemesh::comparison
