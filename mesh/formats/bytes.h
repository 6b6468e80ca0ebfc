// Bytes of files: loading, byte order, and bounds that are checked before anything is read.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "config/buffer.h"

namespace kinemesh {

static_assert(std::endian::native == std::endian::little,
              "Kinemesh runs on little-endian machines");

/// The whole file, without clearing the memory first. Throws InputError.
Buffer<std::byte> load_bytes(const std::filesystem::path& path);

inline std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class T>
T swap_bytes(T value) {
  static_assert(std::is_trivially_copyable_v<T>);
  if constexpr (sizeof(T) == 1) {
    return value;
  } else if constexpr (sizeof(T) == 2) {
    return std::bit_cast<T>(__builtin_bswap16(std::bit_cast<uint16_t>(value)));
  } else if constexpr (sizeof(T) == 4) {
    return std::bit_cast<T>(__builtin_bswap32(std::bit_cast<uint32_t>(value)));
  } else {
    return std::bit_cast<T>(__builtin_bswap64(std::bit_cast<uint64_t>(value)));
  }
}

/// The value at `from`, which need not be aligned.
template <class T>
T load_value(const void* from, bool big_endian = false) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return big_endian ? swap_bytes(value) : value;
}

/// Copies `count` values, their bytes swapped; the ranges are equal or apart.
void copy_swapped(const void* from, float* to, std::size_t count);

/// Appends the bytes of `value`.
template <class T>
void append_value(std::string& out, T value, bool big_endian = false) {
  if (big_endian) value = swap_bytes(value);
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Reads values one after the other; running past the end throws InputError with the byte.
class ByteReader {
 public:
  ByteReader(std::span<const std::byte> bytes, std::string name, bool big_endian = false)
      : bytes_(bytes), name_(std::move(name)), big_endian_(big_endian) {}

  std::size_t position() const { return position_; }
  std::size_t remaining() const { return bytes_.size() - position_; }
  template <class T>
  T value() {
    require(sizeof(T));
    const T read = load_value<T>(bytes_.data() + position_, big_endian_);
    position_ += sizeof(T);
    return read;
  }
  /// The next `count` bytes.
  std::span<const std::byte> take(std::size_t count);
  /// Throws InputError when fewer than `count` bytes are left.
  void require(std::size_t count) const;
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::span<const std::byte> bytes_;
  std::string name_;
  std::size_t position_ = 0;
  bool big_endian_ = false;
};

}  // namespace kinemesh
