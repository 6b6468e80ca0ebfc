// What differs between two sessions: frames, markers, values, events, analog data and parameters.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

struct SessionDiffOptions {
  double tolerance_mm = 0.001;        ///< positions and residuals that are closer count as equal
  double event_tolerance_s = 0.0005;  ///< events that are closer count as equal
  double analog_tolerance = 1e-6;     ///< relative to the channel's largest value
  bool parameters = true;             ///< compare the parameters of C3D files too

  void declare(ParameterSet& p);
  /// Throws UsageError.
  void validate() const;
};

enum class DifferenceKind : uint8_t {
  frames,
  rate,
  marker,
  order,
  position,
  validity,
  residual,
  camera_mask,
  event,
  analog,
  rotation,
  parameter
};
/// "frames", "rate", "marker", …: the words of the JSON output.
std::string_view name_of(DifferenceKind kind);

struct Difference {
  DifferenceKind kind = DifferenceKind::frames;
  std::string place;  ///< "marker Anna:LFHD", "event Smile", "parameter POINT:UNITS"; may be empty
  std::string message;    ///< one sentence without a full stop
  std::size_t count = 0;  ///< samples concerned; 0 where that makes no sense
  double largest = 0.0;   ///< largest difference, in the unit of the value
  int64_t frame = 0;      ///< frame of the largest (or the first) difference; 0 for none
};

struct SessionDiffResult {
  std::vector<Difference> differences;
  bool identical() const { return differences.empty(); }
};

/// Markers are matched by subject and label (several of one name in their order), frames by their
/// number. Positions are compared where both are valid.
SessionDiffResult diff_sessions(const MarkerSequence& a, const MarkerSequence& b,
                                const SessionDiffOptions& options = {}, const RunContext& ctx = {});

/// For a person. `a` and `b` are the names to show.
std::string diff_text(const SessionDiffResult& result, const std::string& a, const std::string& b);
/// The document that docs/c3d.md describes.
std::string diff_json(const SessionDiffResult& result, const std::string& a, const std::string& b);

}  // namespace kinemesh
