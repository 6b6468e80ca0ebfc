// The ezc3d library as a second reader, for comparison. Nothing else in Kinemesh uses ezc3d.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "capture/c3d/reader.h"

namespace kinemesh {

/// Why ezc3d cannot read a file that our reader read into `result`; empty when it can. It runs
/// only on what is healthy: damaged files crash it, hang it or exhaust the memory.
std::string ezc3d_refusal(const C3dReadResult& result);

/// Replaces positions, flags and analog values of `result` by what ezc3d reads from the file.
/// Residuals and camera masks become 0, because ezc3d 1.7.2 exchanges them, unless `as_it_says`.
/// Throws InputError when ezc3d_refusal() is not empty or ezc3d fails.
void reread_with_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
                       C3dReadResult& result, bool as_it_says = false);

/// Loads a file with ezc3d and does nothing else with it: the reference of the benchmark. Returns
/// the number of frames. Throws what ezc3d throws.
std::size_t load_with_ezc3d(const std::filesystem::path& path);

}  // namespace kinemesh
