// Length units of files. Inside Kinemesh every length is in millimetres.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace kinemesh {

enum class LengthUnit { um, mm, cm, m, inch, foot };

inline constexpr std::array all_length_units{LengthUnit::um, LengthUnit::mm,   LengthUnit::cm,
                                             LengthUnit::m,  LengthUnit::inch, LengthUnit::foot};

/// Millimetres in one `unit`.
double millimetres_per(LengthUnit unit);
/// "um", "mm", "cm", "m", "in", "ft".
std::string_view name_of(LengthUnit unit);
/// The unit of that name, any case, also as written by other programs ("millimetres", "Meters",
/// "mete"); empty for unknown words.
std::optional<LengthUnit> length_unit_of(std::string_view name);

}  // namespace kinemesh
