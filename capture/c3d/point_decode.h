// Decodes the points and analog samples of one frame into the arrays of a MarkerSequence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "capture/c3d/analog_table.h"
#include "capture/c3d/layout.h"
#include "capture/c3d/point_table.h"
#include "capture/c3d/reader.h"

namespace kinemesh {

/// How often a peculiarity occurred, and in which frame (0-based) first.
struct Occurrence {
  uint64_t count = 0;
  std::size_t first_frame = 0;
  void add(uint64_t more, std::size_t frame) {
    if (more != 0 && count == 0) first_frame = frame;
    count += more;
  }
};

struct PointOccurrences {
  Occurrence zero_gaps;           ///< at (0, 0, 0) with a residual ≥ 0, taken as gaps
  Occurrence not_finite;          ///< NaN or infinite with a residual ≥ 0
  Occurrence unsigned_minus_one;  ///< a fourth word of 65535.0
  Occurrence odd_words;           ///< fourth words that fit no 16-bit integer
  Occurrence sentinels;           ///< at (−16512, −16512, −16512)
  Occurrence far_away;            ///< over 1 km from the origin
};

/// Where one frame's points go: points × 3 floats, and points values each.
struct FrameTarget {
  float* positions;
  uint8_t* flags;
  float* residuals;
  uint8_t* camera_masks;
};

class PointDecoder {
 public:
  PointDecoder(const C3dLayout& layout, const PointTable& table, ZeroPolicy zero_points);
  /// `stored` are the frame's points in the machine's number format, 4-byte aligned.
  void decode(const void* stored, const FrameTarget& to, std::size_t frame);
  const PointOccurrences& occurrences() const { return occurrences_; }

 private:
  std::size_t points_;
  Storage storage_;
  bool uniform_;
  std::vector<float> position_scales_;  // per point
  std::vector<float> residual_scales_;  // per point
  std::vector<float> far_limits_;       // per point, in stored units
  std::vector<uint32_t> zero_is_gap_;   // per point, 0 or 1
  PointOccurrences occurrences_;
};

class AnalogDecoder {
 public:
  AnalogDecoder(const C3dLayout& layout, const AnalogTable& table);
  /// `stored` are the frame's samples in the machine's number format.
  void decode(const std::byte* stored, float* values) const;

 private:
  Storage storage_;
  bool unsigned_;
  bool plain_ = true;            // offset 0, factor 1 throughout
  std::size_t count_;            // of samples in a frame
  std::vector<double> offsets_;  // per channel, repeated for a few samples
  std::vector<double> factors_;
};

}  // namespace kinemesh
