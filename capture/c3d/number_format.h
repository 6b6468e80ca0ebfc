// The three number formats of C3D files: Intel (little-endian IEEE), DEC (little-endian integers,
// VAX F floats) and SGI/MIPS (big-endian IEEE).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "capture/marker_sequence.h"

namespace kinemesh {

static_assert(std::endian::native == std::endian::little,
              "the conversions below assume a little-endian machine");

/// 84, 85 or 86 in the parameter section's fourth byte.
constexpr uint8_t processor_byte(Processor p) {
  return static_cast<uint8_t>(84 + static_cast<uint8_t>(p));
}
std::optional<Processor> processor_from(uint8_t byte);
/// "intel", "dec", "sgi": the words of options and of the JSON output.
std::string_view name_of(Processor p);
/// "int", "float".
std::string_view name_of(Storage s);

/// Bits of a VAX F float, read as two little-endian 16-bit words, as an IEEE float. The reserved
/// operand (sign without exponent) becomes NaN.
float float_from_dec(uint32_t stored);
/// The nearest stored form; values beyond ±1.7e38 saturate, NaN becomes the reserved operand.
uint32_t dec_from_float(float value);

uint16_t read_u16(const std::byte* at, Processor p);
inline int16_t read_i16(const std::byte* at, Processor p) {
  return static_cast<int16_t>(read_u16(at, p));
}
float read_real(const std::byte* at, Processor p);
void append_u16(std::string& to, uint16_t value, Processor p);
void append_real(std::string& to, float value, Processor p);

/// Converts stored 32-bit floats to the machine's, in place. `bytes` need not be aligned.
void reals_to_native(std::byte* bytes, std::size_t count, Processor p);
/// The way back.
void reals_from_native(std::byte* bytes, std::size_t count, Processor p);
/// Converts stored 16-bit words to the machine's, or back, in place.
void swap_words(std::byte* bytes, std::size_t count, Processor p);

}  // namespace kinemesh
