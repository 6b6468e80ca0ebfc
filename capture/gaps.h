// Gaps of a take: for each marker, the stretches of frames in which it was not measured.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "capture/marker_sequence.h"

namespace kinemesh {

/// Frames [begin, end), 0-based within the take.
struct FrameRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - begin; }
  friend bool operator==(const FrameRange&, const FrameRange&) = default;
};

/// What counts as missing.
enum class GapKind {
  unusable,    ///< invalid samples alone: what gap filling still has to fill
  unmeasured,  ///< invalid samples and those that gap filling has estimated
};

struct MarkerGaps {
  std::size_t marker = 0;        ///< index into markers()
  std::size_t missing = 0;       ///< frames
  double missing_percent = 0.0;  ///< of the take's frames; 0 for a take without frames
  std::size_t longest = 0;       ///< frames
  std::vector<FrameRange> gaps;  ///< in order of time, never touching each other
};

/// One entry per marker, in the order of markers().
std::vector<MarkerGaps> find_gaps(const MarkerSequence& take, GapKind kind = GapKind::unmeasured);
MarkerGaps find_gaps(const MarkerSequence& take, std::size_t marker,
                     GapKind kind = GapKind::unmeasured);

/// Frames in which every marker of `markers` is measured (valid and not filled), in order.
std::vector<std::size_t> complete_frames(const MarkerSequence& take,
                                         std::span<const std::size_t> markers);

}  // namespace kinemesh
