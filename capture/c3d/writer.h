// Writes a MarkerSequence as C3D for any processor and storage.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/c3d/finding.h"
#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

struct C3dWriteOptions {
  /// "origin" writes as the take was stored.
  std::string processor = "origin";  ///< intel, dec, sgi or origin
  std::string storage = "origin";    ///< int, float or origin
  std::string unit = "origin";       ///< mm, cm, m or origin
  /// Size of one integer step in the written unit; 0 chooses: the take's own scale when it was
  /// integer and still fits, otherwise the smallest step that holds the largest coordinate.
  double scale = 0.0;
  void declare(ParameterSet& p);
  /// Throws UsageError.
  void validate() const;
};

/// What the target cannot hold, found before anything is written.
struct C3dLoss {
  std::string message;  ///< "positions are rounded to steps of 0.08 mm (error up to 0.04 mm)"
  std::string place;    ///< "marker LFHD", "parameter SUBJECTS:NAMES"; may be empty
  friend bool operator==(const C3dLoss&, const C3dLoss&) = default;
};

struct C3dWriteResult {
  std::vector<C3dLoss> losses;
  std::uintmax_t bytes = 0;
};

/// The losses that write_c3d would report, without writing.
std::vector<C3dLoss> c3d_losses(const MarkerSequence& take, const C3dWriteOptions& options = {});

/// Every parameter of take.parameters is kept; those that describe the data (USED, FRAMES, LABELS,
/// RATE, SCALE, UNITS, EVENT…) are brought up to date. Throws InputError when the file cannot be
/// written, UsageError when the format cannot hold the take at all.
C3dWriteResult write_c3d(const MarkerSequence& take, const std::filesystem::path& path,
                         const C3dWriteOptions& options = {}, const RunContext& ctx = {});
/// The same into memory.
std::string encode_c3d(const MarkerSequence& take, const C3dWriteOptions& options = {},
                       std::vector<C3dLoss>* losses = nullptr);

}  // namespace kinemesh
