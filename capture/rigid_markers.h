// Finds, from the motion alone, the markers that are fixed to the skull.
#pragma once

#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/run_context.h"

namespace kinemesh {

struct RigidMarkersResult {
  std::vector<std::size_t> markers;  ///< indices, ascending; empty when nothing moves as one body
  double residual_mm = 0.0;          ///< RMS distance from their mean shape, 3D
};

/// Starts from the four markers (three, if there are no more) whose mutual distances change least
/// over all frames in relation to their length, so that a small patch of skin cannot win over a
/// rig that spans the head; then adds the markers that fit, until none does: those no farther from
/// their place than the error of the first four, carried over to where they lie, explains (× 1.4).
/// Skin that stays still relative to the skull in this take fits, too. Only
/// points of kind `marker` that are measured in half of the take, or more, are considered; the
/// worst hundredth of the frames (jumps) is disregarded.
RigidMarkersResult find_rigid_markers(const MarkerSequence& take, const RunContext& ctx = {});

/// Throws the NoResultError of a take without enough rigid markers; `what`: a sentence on it.
[[noreturn]] void no_rigid_markers(const MarkerSequence& take, const std::string& what);

}  // namespace kinemesh
