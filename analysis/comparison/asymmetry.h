// How much more the left does than the right, in each of two performances.
#pragma once

#include <string>
#include <vector>

#include "analysis/comparison/measures.h"
#include "analysis/comparison/regions.h"

namespace kinemesh {

struct Asymmetry {
  double left_mm = 0.0, right_mm = 0.0;
  /// (left − right) over their mean, %: positive where the left moves more; 0 without movement.
  double percent = 0.0;
  double onset_ms = 0.0;  ///< left's onset less right's; NaN where one of them does not move
};

struct AsymmetryRow {
  std::string name;  ///< without left and right
  Asymmetry a, b;
};

/// Of all regions and measures whose names differ in "left" and "right" alone: by their largest
/// amount, and by the change of the measure.
std::vector<AsymmetryRow> asymmetry_of(const std::vector<RegionResult>& regions,
                                       const std::vector<MeasureResult>& measures);

}  // namespace kinemesh
