// ezc3d in a process of its own: even files that are sound make it crash, loop or take gigabytes.
#pragma once

#include <filesystem>
#include <string>

#include "capture/c3d/ezc3d_reader.h"
#include "capture/c3d/reader.h"
#include "config/run_context.h"

namespace kinemesh {

/// Does what read_with_ezc3d() does, but in a child process with limits on time and memory. Returns
/// an empty text, or why there is no result: what ezc3d says against the file, that it crashed, or
/// that it took too long or too much memory; `result` is unchanged then. Throws CancelledError when
/// ctx is cancelled meanwhile.
std::string read_with_ezc3d_apart(const std::filesystem::path& path, const C3dReadOptions& options,
                                  C3dReadResult& result, Ezc3dHead& head,
                                  const RunContext& ctx = {});

/// What `--reader ezc3d` gives: positions, validity, analog values and rotations of `result` are
/// replaced by ezc3d's. Residuals and camera masks become 0, because ezc3d 1.7.2 exchanges them.
/// Throws InputError where ezc3d cannot read the file.
void reread_with_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
                       C3dReadResult& result, const RunContext& ctx = {});

}  // namespace kinemesh
