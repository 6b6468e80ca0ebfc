// ezc3d in a process of its own: even files that are sound make it crash, loop or take gigabytes.
#pragma once

#include <filesystem>
#include <string>

#include "capture/c3d/reader.h"
#include "config/run_context.h"

namespace kinemesh {

/// Does what reread_with_ezc3d() does, residuals and camera masks as ezc3d says them, but in a
/// child process with limits on time and memory. Returns an empty text, or why there is no result:
/// what ezc3d says against the file, that it crashed, or that it took too long or too much memory.
/// Throws CancelledError when ctx is cancelled meanwhile.
std::string reread_with_ezc3d_apart(const std::filesystem::path& path,
                                    const C3dReadOptions& options, C3dReadResult& result,
                                    const RunContext& ctx = {});

}  // namespace kinemesh
