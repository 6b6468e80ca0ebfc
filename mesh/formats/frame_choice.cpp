#include "mesh/formats/frame_choice.h"

#include <charconv>

#include "config/error.h"

namespace kinemesh {

FrameChoice chosen_frames(const std::string& text, int64_t first_frame, std::size_t frame_count) {
  FrameChoice range{0, frame_count, 1};
  if (text.empty()) return range;
  const int64_t last_frame = first_frame + static_cast<int64_t>(frame_count) - 1;
  const auto refuse = [&]() {
    throw UsageError({.what = "option 'frames': it was given as '" + text +
                              "', but must be FIRST, FIRST:LAST or FIRST:LAST:STEP within " +
                              std::to_string(first_frame) + " to " + std::to_string(last_frame)});
  };
  int64_t numbers[3] = {first_frame, last_frame, 1};
  int parts = 0;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (; parts < 3; ++parts) {
    const bool empty = at == end || *at == ':';
    if (!empty) {
      const auto [next, error] = std::from_chars(at, end, numbers[parts]);
      if (error != std::errc()) refuse();
      at = next;
    }
    if (at == end) break;
    if (*at++ != ':') refuse();
  }
  if (parts == 3) refuse();
  if (parts == 0) numbers[1] = numbers[0];
  if (numbers[0] < first_frame || numbers[1] > last_frame || numbers[0] > numbers[1] ||
      numbers[2] < 1) {
    refuse();
  }
  range.first = static_cast<std::size_t>(numbers[0] - first_frame);
  range.step = static_cast<std::size_t>(numbers[2]);
  range.count = static_cast<std::size_t>(numbers[1] - numbers[0]) / range.step + 1;
  return range;
}

}  // namespace kinemesh
