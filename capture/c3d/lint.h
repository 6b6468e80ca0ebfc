// What is readable in a session, yet worth a second look before working with it.
#pragma once

#include <vector>

#include "capture/c3d/finding.h"
#include "capture/c3d/layout.h"
#include "capture/marker_sequence.h"
#include "config/run_context.h"

namespace kinemesh {

/// Codes C3D7xx of c3d_finding_kinds(): markers never measured, units that cannot be right, values
/// at the limit of their range, and the like. `layout` is null when the session is no C3D file.
/// Each code is reported once, naming the markers, frames or parameters concerned.
std::vector<C3dFinding> lint_session(const MarkerSequence& take, const C3dLayout* layout,
                                     const RunContext& ctx = {});

}  // namespace kinemesh
