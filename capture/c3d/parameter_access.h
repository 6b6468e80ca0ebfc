// Reading values out of the parameter tree with the conventions of C3D.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/c3d/parameters.h"

namespace kinemesh {

/// First finite number of a parameter; nothing when it is missing, text or empty.
std::optional<double> first_number(const C3dParameters& tree, std::string_view group,
                                   std::string_view name);
/// The same as a count: 16-bit integers are unsigned, reals are rounded; negative reals give none.
std::optional<uint64_t> first_count(const C3dParameters& tree, std::string_view group,
                                    std::string_view name);
/// First string; empty when missing.
std::string first_string(const C3dParameters& tree, std::string_view group, std::string_view name);
/// The strings of NAME, NAME2, NAME3… as one list: a parameter holds at most 255.
std::vector<std::string> all_strings(const C3dParameters& tree, std::string_view group,
                                     const std::string& name);
/// TRIAL fields: two 16-bit words, the low one first, make one 32-bit number.
std::optional<uint64_t> long_count(const C3dParameters& tree, std::string_view group,
                                   std::string_view name);

/// A value as stored in a signed 16-bit integer, taken as unsigned.
inline double as_unsigned(double value) { return value < 0.0 ? value + 65536.0 : value; }

/// Brings the lengths of the force plates, which stand in the points' unit, into another one.
void scale_force_plates(C3dParameters& tree, double factor);

/// Parameters ready for C3dParameters::set().
C3dParameter real_parameter(std::string name, std::vector<double> values,
                            std::vector<uint8_t> dimensions = {});
C3dParameter integer_parameter(std::string name, std::vector<double> values,
                               std::vector<uint8_t> dimensions = {});
/// One string of its own length, or a [width, count] array padded with spaces to the longest
/// (at most 255 bytes each, 255 strings).
C3dParameter text_parameter(std::string name, std::string_view text);
C3dParameter texts_parameter(std::string name, const std::vector<std::string>& texts);

}  // namespace kinemesh
