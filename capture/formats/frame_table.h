// The common part of all text formats: rows of frames, three columns a marker.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "capture/formats/table_text.h"
#include "capture/marker_sequence.h"
#include "config/run_context.h"
#include "mesh/formats/options.h"

namespace kinemesh {

/// What a reader of text tables is told.
struct TableReadOptions {
  bool zero_is_gap = true;  ///< a point at exactly (0, 0, 0) counts as not measured
  ReadOptions unstated;     ///< unit and rate of tables that do not say theirs
};

/// Where the values of one marker stand (0-based cells).
struct PointColumns {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  Marker marker;
  std::array<std::size_t, 3> xyz{};
  std::size_t valid = none;        ///< 0 no data, 1 measured, 2 estimated
  std::size_t residual = none;     ///< mm
  std::size_t uncertainty = none;  ///< mm; of estimated samples
};

/// Which part of a text is the table, and how to read it.
struct FrameTable {
  std::size_t first_line = 0;  ///< 0-based line of the first frame
  char separator = ',';
  double millimetres = 1.0;  ///< in one unit of length of the table
  std::vector<PointColumns> points;
  std::size_t frame_column = PointColumns::none;
  std::size_t time_column = PointColumns::none;
  double rate_hz = 0.0;             ///< 0: take it from the times
  int64_t frame_number_offset = 0;  ///< added to the frame column to count from 1
  std::size_t declared_frames = 0;  ///< 0 when the file does not say
};

/// Reads all rows. Blank cells are gaps; frames left out of the frame column are gaps of every
/// marker. Warns through ctx about a last line that is cut off (it is dropped) and about counts
/// and times that disagree. Throws InputError naming file and line for cells that are no numbers,
/// frame numbers that do not ascend, a marker with only some coordinates, a table without rows,
/// and a rate that cannot be known.
MarkerSequence read_frame_table(const TableText& text, const FrameTable& table,
                                const TableReadOptions& options, const RunContext& ctx);

}  // namespace kinemesh
