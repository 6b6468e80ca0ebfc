// Sessions out to tables and arrays: CSV, TRC, JSON and NumPy archives.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/run_context.h"

namespace kinemesh {

enum class ExportFormat { csv, trc, json, npz };

/// The format that a file's extension asks for. Throws UsageError naming the extensions.
/// `others`: extensions that the caller writes itself, to be named beside these (".c3d, ").
ExportFormat export_format_of(const std::filesystem::path& path, const std::string& others = "");

struct SessionExportResult {
  std::vector<std::filesystem::path> files;  ///< written, in order
  std::vector<std::string> left_out;         ///< what the format cannot hold: "3 events"
};

/// Writes the session in the format of the path's extension. CSV writes up to three tables:
/// OUT.csv (points), OUT.analog.csv and OUT.events.csv, the last two only where there is something
/// to write. docs/c3d.md documents columns, fields and arrays. Throws InputError when a file cannot
/// be written; then none is.
SessionExportResult export_session(const MarkerSequence& take, const std::filesystem::path& path,
                                   const RunContext& ctx = {});

/// 0 no data, 1 measured, 2 estimated by Kinemesh: frames × markers.
std::vector<uint8_t> validity_codes(const MarkerSequence& take);

}  // namespace kinemesh
