// The frame of a take whose markers are triangulated.
#pragma once

#include <cstdint>

#include "capture/marker_sequence.h"
#include "reconstruct/edit_mesh.h"

namespace kinemesh {

struct ReferenceFrame {
  std::size_t frame = 0;            ///< 0-based
  std::size_t measured = 0;         ///< markers measured in it (valid and not filled)
  std::size_t frames_measured = 0;  ///< frames in which all are
  Points points;                    ///< positions of all markers in it, mm
};

/// The first frame in which all markers are measured; without one, the first of those with the
/// most; or the frame numbered `wanted` as in the file (-1: choose). Throws UsageError when the
/// take has no such frame, InputError for an invalid or infinite sample in it, NoResultError for a
/// take without frames.
ReferenceFrame choose_reference_frame(const MarkerSequence& take, int64_t wanted);

/// Index of the frame numbered `wanted` as in the file. Throws UsageError when there is none.
std::size_t frame_numbered(const MarkerSequence& take, int64_t wanted);

}  // namespace kinemesh
