// Encodes frames of a MarkerSequence as a C3D data section.
#pragma once

#include <cstddef>
#include <vector>

#include "capture/c3d/write_plan.h"
#include "capture/marker_sequence.h"

namespace kinemesh {

/// What did not fit while encoding.
struct EncodeTally {
  std::size_t clipped_coordinates = 0;
  std::size_t clipped_residuals = 0;
  std::size_t rounded_residuals = 0;
  std::size_t lost_cameras = 0;     ///< masks that name an eighth camera
  std::size_t ambiguous_zeros = 0;  ///< valid markers at exactly (0, 0, 0)
};

class FrameEncoder {
 public:
  FrameEncoder(const MarkerSequence& take, const C3dWritePlan& plan);
  std::size_t frame_bytes() const { return frame_bytes_; }
  /// Writes frame_bytes() bytes, already in the target's number format.
  void encode(std::size_t frame, std::byte* to, EncodeTally& tally) const;

 private:
  struct Sample {
    const float* position;
    bool valid;
    float residual;
    uint8_t cameras;
  };
  void encode_point(std::size_t point, const Sample& s, std::byte* to, EncodeTally& tally) const;
  void encode_points(std::size_t frame, std::byte* to, EncodeTally& tally) const;
  void encode_analog(std::size_t frame, std::byte* to) const;
  int word_of(std::size_t point, const Sample& s, EncodeTally& tally) const;

  const MarkerSequence& take_;
  const C3dWritePlan& plan_;
  std::size_t analog_values_;
  std::size_t frame_bytes_;
};

}  // namespace kinemesh
