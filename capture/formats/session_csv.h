// Kinemesh's own table of points: a CSV that spreadsheets, pandas and R read, and that comes back
// as the same session. docs/c3d.md documents the columns.
//
//   # kinemesh points csv 1
//   # rate_hz,100
//   # event,LABEL,CONTEXT,SUBJECT,TIME_S
//   # marker,NAME,SUBJECT,LABEL,KIND,UNIT     (only where NAME alone does not say it)
//   frame,time_s,NAME.x,NAME.y,NAME.z,NAME.valid,NAME.residual,…
//
// Where samples are estimated, NAME.uncertainty (standard deviation, mm) follows NAME.residual.
#pragma once

#include <string_view>

#include "capture/formats/frame_table.h"
#include "capture/marker_sequence.h"
#include "config/output_file.h"
#include "config/run_context.h"

namespace kinemesh {

/// True for the first line of such a table, with or without the comment lines.
bool looks_like_session_csv(std::string_view first_line);

/// Reads tables written by write_session_csv, also when a spreadsheet saved them again (semicolons
/// and decimal commas included) and when the comment lines or the columns valid and residual are
/// gone. Throws InputError naming file and line.
MarkerSequence read_session_csv(const TableText& text, const TableReadOptions& options = {},
                                const RunContext& ctx = {});

/// Every point with its coordinates in mm (angles, forces, … in their own unit), shortest decimal
/// text that reads back the same. time_s counts from recorded frame 1, like event times.
/// The file is not committed.
void write_session_csv(const MarkerSequence& take, OutputFile& file, const RunContext& ctx = {});

}  // namespace kinemesh
