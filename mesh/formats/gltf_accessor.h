// Typed reading of glTF accessors out of buffers, every bound checked. For gltf_read.cpp alone.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace kinemesh::gltf {

using Json = nlohmann::json;

/// A parsed document with its buffers.
struct Document {
  std::string name;  ///< of the file, for errors
  Json json;
  std::vector<std::string_view> buffers;

  [[noreturn]] void fail(const std::string& place, const std::string& what) const;
  /// The element `index` of a top-level array. Throws InputError when it is not there.
  const Json& element(const char* array, std::size_t index) const;
};

/// A non-negative integer member, or `fallback` when there is none. Throws InputError for others.
std::size_t index_member(const Document& document, const Json& object, const char* key,
                         std::size_t fallback, const std::string& place);
inline constexpr std::size_t none = static_cast<std::size_t>(-1);

/// All components of an accessor, element by element; normalised integers become 0…1 or −1…1.
/// `components` is the number expected per element. Throws InputError.
std::vector<double> accessor_values(const Document& document, std::size_t index, int components);

}  // namespace kinemesh::gltf
