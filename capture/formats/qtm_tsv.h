// TSV and CSV exports of 3D data from Qualisys Track Manager, as docs.qualisys.com describes them
// under "Motion data (.tsv)": lines of a name and its values, then one row per frame, with or
// without frame number and time and with or without a row of column names.
#pragma once

#include "capture/formats/frame_table.h"
#include "capture/marker_sequence.h"
#include "config/run_context.h"

namespace kinemesh {

/// True when the first line is that of a QTM export with its header.
bool looks_like_qtm(std::string_view first_line);

/// Lengths are mm in QTM. Trajectories of type Virtual become virtual points; events are read.
/// Blank cells and points at (0, 0, 0) (if `options` say so) are gaps. Throws InputError naming
/// file and line, also for exports of anything but 3D data.
MarkerSequence read_qtm(const TableText& text, const TableReadOptions& options = {},
                        const RunContext& ctx = {});

}  // namespace kinemesh
