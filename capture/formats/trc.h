// TRC (track row column) files of Motion Analysis, OpenSim and many others: points alone, without
// validity, residuals, analog data or events.
#pragma once

#include <filesystem>

#include "capture/formats/frame_table.h"
#include "capture/marker_sequence.h"
#include "config/output_file.h"
#include "config/run_context.h"

namespace kinemesh {

/// Reads a TRC file: header keys in any order, separated by tabs (or by commas or semicolons),
/// names above their columns or packed side by side. Lengths become mm. Blank cells and NaN are
/// gaps. Throws InputError naming file and line.
MarkerSequence read_trc(const TableText& text, const TableReadOptions& options = {},
                        const RunContext& ctx = {});

/// Writes the markers, unlabelled and virtual points in mm; gaps as blank cells. Frames keep their
/// numbers and times count from the first of them, as OpenSim expects. Angles, forces and the like
/// are left out.
void write_trc(const MarkerSequence& take, const std::filesystem::path& path,
               const RunContext& ctx = {});
/// The same; the file is not committed.
void write_trc(const MarkerSequence& take, OutputFile& file, const RunContext& ctx = {});

}  // namespace kinemesh
