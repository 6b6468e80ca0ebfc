#include "capture/gaps.h"

#include <algorithm>

namespace kinemesh {
namespace {

bool missing(uint8_t flags, GapKind kind) {
  if ((flags & SampleFlag::valid) == 0) return true;
  return kind == GapKind::unmeasured && (flags & SampleFlag::filled) != 0;
}

}  // namespace

MarkerGaps find_gaps(const MarkerSequence& take, std::size_t marker, GapKind kind) {
  MarkerGaps out;
  out.marker = marker;
  const std::size_t frames = take.frame_count();
  for (std::size_t f = 0; f < frames;) {
    if (!missing(take.flags()[take.sample(f, marker)], kind)) {
      ++f;
      continue;
    }
    FrameRange gap{f, f};
    while (gap.end < frames && missing(take.flags()[take.sample(gap.end, marker)], kind)) {
      ++gap.end;
    }
    out.missing += gap.size();
    out.longest = std::max(out.longest, gap.size());
    out.gaps.push_back(gap);
    f = gap.end;
  }
  if (frames > 0) {
    out.missing_percent = 100.0 * static_cast<double>(out.missing) / static_cast<double>(frames);
  }
  return out;
}

std::vector<MarkerGaps> find_gaps(const MarkerSequence& take, GapKind kind) {
  std::vector<MarkerGaps> out;
  out.reserve(take.marker_count());
  for (std::size_t m = 0; m < take.marker_count(); ++m) out.push_back(find_gaps(take, m, kind));
  return out;
}

std::vector<std::size_t> complete_frames(const MarkerSequence& take,
                                         std::span<const std::size_t> markers) {
  std::vector<std::size_t> out;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const bool all = std::ranges::all_of(markers, [&](std::size_t m) {
      return !missing(take.flags()[take.sample(f, m)], GapKind::unmeasured);
    });
    if (all) out.push_back(f);
  }
  return out;
}

}  // namespace kinemesh
