// The ezc3d library as a second reader, for comparison. Nothing else in Kinemesh uses ezc3d.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/c3d/reader.h"

namespace kinemesh {

/// Why ezc3d cannot read a file that our reader read into `result`; empty when it can. It runs
/// only on what is healthy: damaged files crash it, hang it or exhaust the memory.
std::string ezc3d_refusal(const C3dReadResult& result);

/// What ezc3d says beside the samples.
struct Ezc3dHead {
  C3dParameters parameters;  ///< numbers as ezc3d gives them, signed
  std::vector<C3dHeaderEvent> header_events;
  int64_t first_frame = 1;  ///< counted from 1
  double rate_hz = 0.0;
};

/// Replaces positions, flags, residuals, camera masks, analog values and rotations of `result` by
/// what ezc3d says (residuals and masks included, which version 1.7.2 exchanges), and fills `head`.
/// Crashes, hangs and memory without bound are possible: see ezc3d_process.h. Throws InputError
/// when ezc3d_refusal() is not empty or ezc3d fails.
void read_with_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
                     C3dReadResult& result, Ezc3dHead& head);

/// Loads a file with ezc3d and does nothing else with it: the reference of the benchmark. Returns
/// the number of frames. Throws what ezc3d throws.
std::size_t load_with_ezc3d(const std::filesystem::path& path);

}  // namespace kinemesh
