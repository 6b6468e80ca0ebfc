// Where everything lies in one C3D file, as decided from header, parameters and file size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"

namespace kinemesh {

/// An event of the header block, whose times count from recorded frame 1.
struct C3dHeaderEvent {
  std::string label;  ///< up to four characters
  double time_s = 0.0;
  uint8_t display_flag = 1;  ///< as stored; writers differ on whether 0 or 1 shows the event
  friend bool operator==(const C3dHeaderEvent&, const C3dHeaderEvent&) = default;
};

/// The header block, as stored (all 16-bit words unsigned).
struct C3dHeader {
  uint8_t parameter_block = 0;  ///< 1-based 512-byte block of the parameter section
  uint8_t key = 0;              ///< 80 in a C3D file
  uint16_t points = 0;
  uint16_t analog_per_frame = 0;  ///< channels × samples per frame
  uint16_t first_frame = 0;
  uint16_t last_frame = 0;
  uint16_t max_gap = 0;
  float scale = 0.0F;           ///< negative: floats
  uint16_t data_block = 0;      ///< 1-based
  uint16_t analog_samples = 0;  ///< samples per channel and frame
  float rate_hz = 0.0F;
  std::vector<C3dHeaderEvent> events;  ///< at most 18
  friend bool operator==(const C3dHeader&, const C3dHeader&) = default;
};

/// Where a parameter stands in the file, for findings and repairs.
struct C3dParameterPlace {
  std::string group, name;
  uint64_t record = 0;  ///< byte of the record's first byte (the length of its name)
  uint64_t data = 0;    ///< byte of its first value
  friend bool operator==(const C3dParameterPlace&, const C3dParameterPlace&) = default;
};

/// All offsets are absolute bytes from the start of the file.
struct C3dLayout {
  uint64_t file_bytes = 0;
  uint64_t leading_bytes = 0;     ///< zero bytes before the header
  uint64_t parameters_begin = 0;  ///< the four bytes before the first record
  uint64_t parameters_end = 0;    ///< behind the last record that was read; 0 without parameters
  uint64_t data_begin = 0;
  uint64_t data_end = 0;  ///< behind the last complete frame
  Processor processor = Processor::intel;
  Storage storage = Storage::real;
  double scale = -1.0;  ///< that was applied; |scale| scales the residual
  uint64_t points = 0;
  uint64_t analog_channels = 0;
  uint64_t analog_samples = 0;  ///< per channel and frame
  uint64_t frame_bytes = 0;
  uint64_t frames = 0;           ///< complete ones in the file, as read
  uint64_t declared_frames = 0;  ///< what the file claims; more than `frames` when truncated
  int64_t first_frame = 1;
  double rate_hz = 0.0;
  bool analog_unsigned = false;   ///< integer samples are unsigned 16-bit
  uint64_t rotations = 0;         ///< a sample, of group ROTATION; their data are not points
  uint64_t rotation_samples = 0;  ///< per frame
  uint64_t rotation_frames = 0;   ///< that are complete in the file
  uint64_t rotations_begin = 0;
  std::vector<C3dParameterPlace> places;
};

}  // namespace kinemesh
