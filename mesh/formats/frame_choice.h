// Frames chosen by their numbers: "", "12", "100:200", "100:200:2".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace kinemesh {

/// Indices (0-based) of chosen frames.
struct FrameChoice {
  std::size_t first = 0, count = 0, step = 1;
};

/// Of a take whose frames are numbered from `first_frame`; empty text: all. Throws UsageError for
/// what is malformed or not within the take.
FrameChoice chosen_frames(const std::string& text, int64_t first_frame, std::size_t frame_count);

}  // namespace kinemesh
