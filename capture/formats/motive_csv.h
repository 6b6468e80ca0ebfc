// CSV exports of OptiTrack Motive (format versions 1.2x, as docs.optitrack.com describes them under
// "Data Export: CSV"): a line of general information, rows with type, name, ID and parent of each
// column, then one row per frame.
#pragma once

#include "capture/formats/frame_table.h"
#include "capture/marker_sequence.h"
#include "config/run_context.h"

namespace kinemesh {

/// True when the first line is that of a Motive export.
bool looks_like_motive_csv(std::string_view first_line);

/// Measured markers come first (labelled as "Asset:Label"; "Unlabeled …" becomes kind unlabelled),
/// then the solved positions of rigid-body and bone markers and the pivots of bodies and bones
/// (kind virtual). Rotations and errors are left out. Lengths become mm; Motive's frame 0 becomes
/// frame 1. Throws InputError naming file and line, also for exports without a header.
MarkerSequence read_motive_csv(const TableText& text, const TableReadOptions& options = {},
                               const RunContext& ctx = {});

}  // namespace kinemesh
