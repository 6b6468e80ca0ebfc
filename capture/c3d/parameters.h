// The parameter section of a C3D file as a tree of typed values, independent of byte order.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

/// Types of a C3D parameter; the values are those of the file format.
enum class C3dType : int8_t { text = -1, byte = 1, integer = 2, real = 4 };

/// One parameter. Dimensions are in file order: the first varies fastest; none means a scalar.
struct C3dParameter {
  std::string name;  ///< upper case as in most files, kept as found
  std::string description;
  bool locked = false;
  C3dType type = C3dType::real;
  std::vector<uint8_t> dimensions;
  std::vector<double> numbers;  ///< byte, integer and real: all values (integers as stored, signed)
  std::string characters;       ///< text: all characters, dimensions[0] per string
  /// text: the strings, trailing spaces and NULs removed.
  std::vector<std::string> strings() const;
  friend bool operator==(const C3dParameter&, const C3dParameter&) = default;
};

struct C3dGroup {
  std::string name;
  std::string description;
  bool locked = false;
  int8_t id = 0;  ///< positive; as in the file
  std::vector<C3dParameter> parameters;
  friend bool operator==(const C3dGroup&, const C3dGroup&) = default;
};

/// All groups of a file, in file order. Names compare without case.
struct C3dParameters {
  std::vector<C3dGroup> groups;

  const C3dGroup* group(std::string_view name) const;
  C3dGroup* group(std::string_view name);
  /// Null when the group or the parameter is missing.
  const C3dParameter* find(std::string_view group, std::string_view name) const;
  C3dParameter* find(std::string_view group, std::string_view name);
  /// Creates group and parameter as needed; replaces a parameter of that name.
  void set(std::string_view group, C3dParameter parameter);
  friend bool operator==(const C3dParameters&, const C3dParameters&) = default;
};

}  // namespace kinemesh
