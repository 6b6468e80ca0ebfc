// Clinical measures over time: distances, openings and excursions of named places, when they change
// and how fast.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/comparison/comparison.h"
#include "analysis/comparison/movement_timing.h"
#include "analysis/comparison/performance.h"

namespace kinemesh {

enum class MeasureKind : uint8_t {
  distance,   ///< between two places
  excursion,  ///< of a place from where it is at rest
  opening     ///< mean height of a hole: its area over its width
};

struct MeasureSpec {
  std::string name;
  MeasureKind kind = MeasureKind::distance;
  /// Marker names (with wildcards: their mean) or vertices of A; for an opening its name.
  std::vector<std::string> places;
};

/// JSON: {"mouth width": {"distance": ["LMOU01", "RMOU01"]}, "smile left": {"excursion":
/// ["LMOU01"]}, "mouth": {"opening": ["mouth"]}}. Throws InputError.
std::vector<MeasureSpec> read_measures(const std::filesystem::path& path);

/// What can be measured without names: the height of each opening that both have, and of a mouth
/// its width and the excursions of its corners.
std::vector<MeasureSpec> default_measures(const Performance& a, const Performance& b);

struct MeasureCourse {
  std::vector<double> mm;  ///< per frame of its own time
  double rest_mm = 0.0;
  double change_mm = 0.0;   ///< the largest, with its sign
  double peak_speed = 0.0;  ///< mm/s
  std::optional<MovementTiming> timing;
};

struct MeasureResult {
  MeasureSpec spec;
  MeasureCourse a, b;
};

/// Places that B has no marker for are taken where A's lie on B. Throws InputError naming a place
/// that A does not have.
std::vector<MeasureResult> take_measures(const Comparison& c, const Performance& a,
                                         const Performance& b,
                                         const std::vector<MeasureSpec>& specs,
                                         double rest_window_s);

}  // namespace kinemesh
