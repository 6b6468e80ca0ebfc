#include "mesh/formats/gltf_accessor.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "config/error.h"
#include "mesh/formats/bytes.h"

namespace kinemesh::gltf {
namespace {

/// Strided elements inside a buffer.
struct Range {
  const char* begin = nullptr;
  std::size_t stride = 0;
};

std::size_t size_of_component(std::size_t type) {
  switch (type) {
    case 5120:
    case 5121: return 1;
    case 5122:
    case 5123: return 2;
    case 5125:
    case 5126: return 4;
    default: return 0;
  }
}

template <class T>
double scaled(const char* at, bool normalised) {
  const auto value = static_cast<double>(load_value<T>(at));
  if (!normalised) return value;
  return std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
}

double component(const char* at, std::size_t type, bool normalised) {
  switch (type) {
    case 5120: return scaled<int8_t>(at, normalised);
    case 5121: return scaled<uint8_t>(at, normalised);
    case 5122: return scaled<int16_t>(at, normalised);
    case 5123: return scaled<uint16_t>(at, normalised);
    case 5125: return scaled<uint32_t>(at, normalised);
    default: return load_value<float>(at);
  }
}

int components_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4" || type == "MAT2") return 4;
  if (type == "MAT3") return 9;
  return type == "MAT4" ? 16 : 0;
}

/// Checks that `count` elements of `size` bytes lie inside the view and its buffer.
Range range_of(const Document& d, std::size_t view_index, std::size_t offset, std::size_t count,
               std::size_t size, const std::string& place) {
  const Json& view = d.element("bufferViews", view_index);
  const std::size_t buffer = index_member(d, view, "buffer", none, place);
  const std::size_t begin = index_member(d, view, "byteOffset", 0, place);
  const std::size_t length = index_member(d, view, "byteLength", 0, place);
  const std::size_t stride = index_member(d, view, "byteStride", size, place);
  if (buffer >= d.buffers.size()) d.fail(place, "it refers to a buffer that is not there");
  const std::size_t bytes = d.buffers[buffer].size();
  if (begin > bytes || length > bytes - begin) d.fail(place, "its view ends behind its buffer");
  if (stride < size) d.fail(place, "its stride is smaller than an element");
  if (count > 0 && (offset > length || size > length - offset ||
                    (count - 1) > (length - offset - size) / stride)) {
    d.fail(place, "it ends behind its buffer view");
  }
  return {d.buffers[buffer].data() + begin + offset, stride};
}

struct Layout {
  std::size_t count = 0, type = 0, size = 0;
  int components = 0;
  bool normalised = false;
};

void read_range(const Range& range, const Layout& layout, std::vector<double>& out) {
  const std::size_t component_size = size_of_component(layout.type);
  for (std::size_t i = 0; i < layout.count; ++i) {
    for (int c = 0; c < layout.components; ++c) {
      out.push_back(
          component(range.begin + i * range.stride + static_cast<std::size_t>(c) * component_size,
                    layout.type, layout.normalised));
    }
  }
}

/// Replaces the elements that a sparse accessor lists.
void apply_sparse(const Document& d, const Json& sparse, const Layout& layout,
                  const std::string& place, std::vector<double>& out) {
  Layout index_layout;
  index_layout.count = index_member(d, sparse, "count", 0, place);
  const Json& indices = sparse.at("indices");
  index_layout.type = index_member(d, indices, "componentType", 0, place);
  index_layout.components = 1;
  index_layout.size = size_of_component(index_layout.type);
  if (index_layout.size == 0) d.fail(place, "the type of its sparse indices is not known");
  std::vector<double> where, what;
  read_range(range_of(d, index_member(d, indices, "bufferView", none, place),
                      index_member(d, indices, "byteOffset", 0, place), index_layout.count,
                      index_layout.size, place),
             index_layout, where);
  Layout values = layout;
  values.count = index_layout.count;
  const Json& json = sparse.at("values");
  read_range(
      range_of(d, index_member(d, json, "bufferView", none, place),
               index_member(d, json, "byteOffset", 0, place), values.count, values.size, place),
      values, what);
  const auto components = static_cast<std::size_t>(layout.components);
  for (std::size_t i = 0; i < where.size(); ++i) {
    if (!(where[i] >= 0 && where[i] < static_cast<double>(layout.count))) {
      d.fail(place, "a sparse index is out of range");
    }
    std::copy_n(
        what.begin() + static_cast<std::ptrdiff_t>(i * components), components,
        out.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(where[i]) * components));
  }
}

}  // namespace

void Document::fail(const std::string& place, const std::string& what) const {
  throw InputError({.what = what, .file = name, .place = place});
}

const Json& Document::element(const char* array, std::size_t index) const {
  const auto found = json.find(array);
  if (found == json.end() || !found->is_array() || index >= found->size() ||
      !(*found)[index].is_object()) {
    fail(std::string(array) + (index == none ? "" : "[" + std::to_string(index) + "]"),
         "the file refers to it, but it is not there");
  }
  return (*found)[index];
}

std::size_t index_member(const Document& document, const Json& object, const char* key,
                         std::size_t fallback, const std::string& place) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  if (!found->is_number_unsigned()) {
    document.fail(place, "'" + std::string(key) + "' is no whole number");
  }
  return found->get<std::size_t>();
}

std::vector<double> accessor_values(const Document& d, std::size_t index, int components) {
  const std::string place = "accessor " + std::to_string(index);
  const Json& accessor = d.element("accessors", index);
  Layout layout;
  layout.count = index_member(d, accessor, "count", 0, place);
  layout.type = index_member(d, accessor, "componentType", 0, place);
  layout.components = components_of(accessor.value("type", ""));
  layout.normalised = accessor.value("normalized", false);
  if (layout.components != components) d.fail(place, "its type is not the one that is needed here");
  const std::size_t component_size = size_of_component(layout.type);
  if (component_size == 0) d.fail(place, "its component type is not known");
  layout.size = component_size * static_cast<std::size_t>(components);
  // A view may be missing, which means zeros: no more of them than the buffers have bytes.
  std::size_t bytes = 0;
  for (const auto& buffer : d.buffers) bytes += buffer.size();
  if (layout.count > bytes) d.fail(place, "it has more elements than the file has bytes");
  std::vector<double> out;
  out.reserve(layout.count * static_cast<std::size_t>(components));
  const std::size_t view = index_member(d, accessor, "bufferView", none, place);
  if (view == none) {
    out.assign(layout.count * static_cast<std::size_t>(components), 0.0);
  } else {
    read_range(range_of(d, view, index_member(d, accessor, "byteOffset", 0, place), layout.count,
                        layout.size, place),
               layout, out);
  }
  if (const auto sparse = accessor.find("sparse"); sparse != accessor.end()) {
    apply_sparse(d, *sparse, layout, place, out);
  }
  return out;
}

}  // namespace kinemesh::gltf
