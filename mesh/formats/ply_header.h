// The header of a PLY file: its elements and their properties.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/formats/metadata.h"

namespace kinemesh {

enum class PlyType : uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

/// Bytes of one value.
std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  bool list = false;
  PlyType count_type = PlyType::u8;  ///< of lists
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_list() const;
  /// Bytes of one row in a binary file, without its lists.
  std::size_t stride() const;
  /// Index of a property, or −1.
  int find(std::string_view property) const;
};

struct PlyHeader {
  enum class Order : uint8_t { ascii, little, big };
  Order order = Order::ascii;
  std::vector<PlyElement> elements;
  MetadataReader metadata;
  std::size_t size = 0;  ///< bytes, up to and with the line end of end_header
};

/// Throws InputError naming the line.
PlyHeader parse_ply_header(std::string_view text, const std::string& name);

}  // namespace kinemesh
