#include "capture/c3d/number_format.h"

#include <limits>

#include "config/multiversion.h"

namespace kinemesh {
namespace {

constexpr uint32_t sign_bit = 0x80000000U;
constexpr uint32_t exponent_one = 0x00800000U;

// A VAX float is 0.1m × 2^(e − 128), an IEEE one 1.m × 2^(e − 127): the exponents differ by two.
// Branch-free, so that the loops below vectorise.
inline uint32_t ieee_from_dec_bits(uint32_t stored) {
  const uint32_t bits = (stored << 16) | (stored >> 16);
  const uint32_t sign = bits & sign_bit;
  const uint32_t exponent = (bits >> 23) & 0xFFU;
  const uint32_t normal = bits - 2 * exponent_one;
  // Exponents 1 and 2 are subnormal in IEEE: shift the mantissa with its hidden one.
  const uint32_t mantissa = (bits & 0x007FFFFFU) | exponent_one;
  const uint32_t subnormal = sign | (exponent == 1 ? mantissa >> 2 : mantissa >> 1);
  const uint32_t none = sign != 0 ? 0x7FC00000U : 0U;
  const uint32_t small = exponent == 0 ? none : subnormal;
  return exponent >= 3 ? normal : small;
}

inline uint32_t swap_bytes(uint32_t v) {
  return (v >> 24) | ((v >> 8) & 0xFF00U) | ((v << 8) & 0xFF0000U) | (v << 24);
}

KINEMESH_MULTIVERSION void dec_block(std::byte* bytes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    uint32_t v = 0;
    std::memcpy(&v, bytes + 4 * i, 4);
    v = ieee_from_dec_bits(v);
    std::memcpy(bytes + 4 * i, &v, 4);
  }
}

KINEMESH_MULTIVERSION void swap_block_32(std::byte* bytes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    uint32_t v = 0;
    std::memcpy(&v, bytes + 4 * i, 4);
    v = swap_bytes(v);
    std::memcpy(bytes + 4 * i, &v, 4);
  }
}

KINEMESH_MULTIVERSION void swap_block_16(std::byte* bytes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    uint16_t v = 0;
    std::memcpy(&v, bytes + 2 * i, 2);
    v = static_cast<uint16_t>((v << 8) | (v >> 8));
    std::memcpy(bytes + 2 * i, &v, 2);
  }
}

}  // namespace

std::optional<Processor> processor_from(uint8_t byte) {
  if (byte < 84 || byte > 86) return std::nullopt;
  return static_cast<Processor>(byte - 84);
}

std::string_view name_of(Processor p) {
  switch (p) {
    case Processor::intel: return "intel";
    case Processor::dec: return "dec";
    case Processor::sgi: return "sgi";
  }
  return "intel";
}

std::string_view name_of(Storage s) { return s == Storage::integer ? "int" : "float"; }

float float_from_dec(uint32_t stored) { return std::bit_cast<float>(ieee_from_dec_bits(stored)); }

uint32_t dec_from_float(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  const uint32_t sign = bits & sign_bit;
  const uint32_t exponent = (bits >> 23) & 0xFFU;
  uint32_t out = 0;
  if (value != value) {
    out = sign_bit;
  } else if (exponent >= 254) {
    out = sign | 0x7FFFFFFFU;
  } else if (exponent == 0) {
    // Subnormal: four times the value has the wanted bits unless it still is too small.
    const auto scaled = std::bit_cast<uint32_t>(value * 4.0F);
    out = (scaled >> 23 & 0xFFU) == 0 ? 0U : scaled;
  } else {
    out = bits + 2 * exponent_one;
  }
  return (out << 16) | (out >> 16);
}

uint16_t read_u16(const std::byte* at, Processor p) {
  uint16_t v = 0;
  std::memcpy(&v, at, 2);
  return p == Processor::sgi ? static_cast<uint16_t>((v << 8) | (v >> 8)) : v;
}

float read_real(const std::byte* at, Processor p) {
  uint32_t v = 0;
  std::memcpy(&v, at, 4);
  if (p == Processor::dec) return float_from_dec(v);
  return std::bit_cast<float>(p == Processor::sgi ? swap_bytes(v) : v);
}

void append_u16(std::string& to, uint16_t value, Processor p) {
  const char low = static_cast<char>(value & 0xFFU);
  const char high = static_cast<char>(value >> 8);
  to += p == Processor::sgi ? high : low;
  to += p == Processor::sgi ? low : high;
}

void append_real(std::string& to, float value, Processor p) {
  uint32_t v = std::bit_cast<uint32_t>(value);
  if (p == Processor::dec) v = dec_from_float(value);
  if (p == Processor::sgi) v = swap_bytes(v);
  char bytes[4];
  std::memcpy(bytes, &v, 4);
  to.append(bytes, 4);
}

void reals_to_native(std::byte* bytes, std::size_t count, Processor p) {
  if (p == Processor::dec) dec_block(bytes, count);
  if (p == Processor::sgi) swap_block_32(bytes, count);
}

void reals_from_native(std::byte* bytes, std::size_t count, Processor p) {
  if (p == Processor::sgi) swap_block_32(bytes, count);
  if (p != Processor::dec) return;
  for (std::size_t i = 0; i < count; ++i) {
    float value = 0.0F;
    std::memcpy(&value, bytes + 4 * i, 4);
    const uint32_t stored = dec_from_float(value);
    std::memcpy(bytes + 4 * i, &stored, 4);
  }
}

void swap_words(std::byte* bytes, std::size_t count, Processor p) {
  if (p == Processor::sgi) swap_block_16(bytes, count);
}

}  // namespace kinemesh
