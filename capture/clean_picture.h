// What cleaning did to a session, as one picture: gaps before and after, the trajectories that
// were changed most, the motion of the head.
#pragma once

#include <string>

#include "capture/edit_list.h"
#include "capture/marker_sequence.h"
#include "config/run_context.h"
#include "report/canvas.h"

namespace kinemesh {

/// `edits` are the steps that made `after` of `before`; where they stabilise the head, its motion
/// is drawn before and after, and trajectories are compared in the head's coordinates. Takes of
/// other frames, rates or axes are drawn, too; what cannot be compared then is left out.
Canvas draw_cleaning(const MarkerSequence& before, const MarkerSequence& after,
                     const EditList& edits, const std::string& title, const RunContext& ctx = {});

}  // namespace kinemesh
