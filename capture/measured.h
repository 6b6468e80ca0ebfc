// Which samples of a take were seen, not filled.
#pragma once

#include "capture/marker_sequence.h"

namespace kinemesh {

/// True when the marker was seen in this frame: valid, not filled, and of finite coordinates.
inline bool measured(const MarkerSequence& take, std::size_t frame, std::size_t marker) {
  return take.valid(frame, marker) && !take.filled(frame, marker) &&
         take.position(frame, marker).allFinite();
}

}  // namespace kinemesh
