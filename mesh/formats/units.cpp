#include "mesh/formats/units.h"

#include <string>

#include "config/text.h"

namespace kinemesh {

double millimetres_per(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::um: return 1e-3;
    case LengthUnit::mm: return 1.0;
    case LengthUnit::cm: return 10.0;
    case LengthUnit::m: return 1000.0;
    case LengthUnit::inch: return 25.4;
    case LengthUnit::foot: return 304.8;
  }
  return 1.0;
}

std::string_view name_of(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::um: return "um";
    case LengthUnit::mm: return "mm";
    case LengthUnit::cm: return "cm";
    case LengthUnit::m: return "m";
    case LengthUnit::inch: return "in";
    case LengthUnit::foot: return "ft";
  }
  return "mm";
}

std::optional<LengthUnit> length_unit_of(std::string_view name) {
  const std::string word = lower(trim(name));
  const auto begins = [&word](std::string_view prefix) { return word.starts_with(prefix); };
  if (word == "um" || word == "µm" || begins("microm")) return LengthUnit::um;
  if (word == "mm" || begins("mill")) return LengthUnit::mm;
  if (word == "cm" || begins("cent")) return LengthUnit::cm;
  if (word == "m" || begins("mete") || begins("metr")) return LengthUnit::m;
  if (word == "in" || word == "\"" || begins("inch")) return LengthUnit::inch;
  if (word == "ft" || word == "foot" || word == "feet") return LengthUnit::foot;
  return std::nullopt;
}

}  // namespace kinemesh
