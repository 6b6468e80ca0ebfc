#include "reconstruct/reference_frame.h"

#include <string>

#include "config/error.h"

namespace kinemesh {
namespace {

std::size_t count_measured(const MarkerSequence& take, std::size_t frame) {
  std::size_t count = 0;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    count += take.valid(frame, m) && !take.filled(frame, m) ? 1 : 0;
  }
  return count;
}

}  // namespace

std::size_t frame_numbered(const MarkerSequence& take, int64_t wanted) {
  const int64_t last = take.first_frame + static_cast<int64_t>(take.frame_count()) - 1;
  if (wanted < take.first_frame || wanted > last) {
    throw UsageError({.what = "--frame " + std::to_string(wanted) + ": there is no such frame",
                      .file = take.origin.path,
                      .remedy = "The take has the frames " + std::to_string(take.first_frame) +
                                " to " + std::to_string(last)});
  }
  return static_cast<std::size_t>(wanted - take.first_frame);
}

ReferenceFrame choose_reference_frame(const MarkerSequence& take, int64_t wanted) {
  if (take.frame_count() == 0) {
    throw NoResultError({.what = "the take has no frames", .file = take.origin.path});
  }
  ReferenceFrame chosen;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const std::size_t measured = count_measured(take, f);
    chosen.frames_measured += measured == take.marker_count() ? 1 : 0;
    if (measured > chosen.measured) {
      chosen.measured = measured;
      chosen.frame = f;
    }
  }
  if (wanted != -1) {
    chosen.frame = frame_numbered(take, wanted);
    chosen.measured = count_measured(take, chosen.frame);
  }
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const auto p = take.position(chosen.frame, m);
    if (!take.valid(chosen.frame, m) || !p.allFinite()) {
      throw InputError({.what = "a marker has no position in the frame to triangulate",
                        .file = take.origin.path,
                        .marker = take.markers()[m].label,
                        .frame = take.first_frame + static_cast<int64_t>(chosen.frame),
                        .remedy = "Fill the gaps of the take first, or leave this marker out"});
    }
    chosen.points.emplace_back(p.cast<double>());
  }
  return chosen;
}

}  // namespace kinemesh
