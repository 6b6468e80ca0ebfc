// What ezc3d reads from a healthy C3D file, beside what our reader reads, difference by difference.
#pragma once

#include <filesystem>

#include "capture/c3d/check.h"
#include "capture/c3d/ezc3d_reader.h"
#include "capture/c3d/reader.h"
#include "config/run_context.h"

namespace kinemesh {

/// Lets ezc3d read the file, in a process of its own, and adds what it reads differently, or why it
/// was not asked, to `result` (C3D801 to C3D804); sets its second opinion.
void ask_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
               const C3dReadResult& own, C3dCheckResult& result, const RunContext& ctx = {});

/// Compares the samples, masks, rotations and analog values of `other` and what `head` says beside
/// them (parameters, labels, events, frame numbers, rate) with `own`. Each kind of difference is
/// one finding: C3D802 where ezc3d is known to be wrong, otherwise C3D803.
void compare_readers(const C3dReadResult& own, MarkerSequence other, const Ezc3dHead& head,
                     C3dCheckResult& result, const RunContext& ctx = {});

}  // namespace kinemesh
