// What the points of a C3D file are: labels, subjects, kinds, units, descriptions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/c3d/finding.h"
#include "capture/marker_sequence.h"
#include "mesh/formats/units.h"

namespace kinemesh {

/// Millimetres in one of a length unit as C3D files spell it ("mm", "mete", "centimeters"), in any
/// case; nothing when the word is no length unit.
std::optional<double> millimetres_in(std::string_view unit);

/// UTF-8 as it is; anything else is taken as Windows-1252, and `converted` becomes true.
std::string utf8_from(const std::string& text, bool& converted);

struct PointTable {
  std::vector<Marker> markers;
  std::vector<float> to_mm;            ///< factor from the file's unit; 1 for what is no length
  std::vector<uint8_t> zero_is_value;  ///< 1 for kinds whose value may well be (0, 0, 0)
  std::string length_unit = "mm";      ///< of the file
  bool uniform = true;                 ///< all factors are 1
};

/// One entry per point. `unstated` stands in where the file names no length unit.
PointTable decode_points_table(const C3dParameters& parameters, std::size_t points,
                               LengthUnit unstated, std::vector<C3dFinding>& findings);

/// The label as it is written into a file whose SUBJECTS group is `parameters`: with the subject's
/// prefix where that group's labels have prefixes.
std::string file_label(const Marker& marker, const C3dParameters& parameters);

}  // namespace kinemesh
