#include <algorithm>
#include <array>
#include <limits>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/faces.h"
#include "mesh/formats/ply.h"
#include "mesh/formats/ply_header.h"
#include "mesh/formats/text_scanner.h"

namespace kinemesh {
namespace {

/// What a column of the vertex element is for.
enum class Column : uint8_t { skip, x, y, z, filled, uncertainty };

std::vector<Column> columns_of(const PlyElement& vertex) {
  std::vector<Column> columns;
  for (const PlyProperty& p : vertex.properties) {
    const std::string_view n = p.list ? std::string_view() : p.name;
    columns.push_back(n == "x"             ? Column::x
                      : n == "y"           ? Column::y
                      : n == "z"           ? Column::z
                      : n == "filled"      ? Column::filled
                      : n == "uncertainty" ? Column::uncertainty
                                           : Column::skip);
  }
  return columns;
}

double value_as_double(const std::byte* at, PlyType type, bool big) {
  switch (type) {
    case PlyType::i8: return load_value<int8_t>(at);
    case PlyType::u8: return load_value<uint8_t>(at);
    case PlyType::i16: return load_value<int16_t>(at, big);
    case PlyType::u16: return load_value<uint16_t>(at, big);
    case PlyType::i32: return load_value<int32_t>(at, big);
    case PlyType::u32: return load_value<uint32_t>(at, big);
    case PlyType::f32: return load_value<float>(at, big);
    case PlyType::f64: return load_value<double>(at, big);
  }
  return 0.0;
}

/// An integer, with −1 for what is no index (negative, fractional, too large).
int64_t value_as_index(const std::byte* at, PlyType type, bool big) {
  const double value = value_as_double(at, type, big);
  if (!(value >= 0 && value < 4294967295.0)) return -1;
  const auto index = static_cast<int64_t>(value);
  return static_cast<double>(index) == value ? index : -1;
}

class PlyReader {
 public:
  PlyReader(std::span<const std::byte> bytes, const std::string& name)
      : bytes_(bytes),
        name_(name),
        header_(parse_ply_header(text_of(bytes), name)),
        big_(header_.order == PlyHeader::Order::big),
        at_(header_.size) {}

  MeshData read() {
    const bool ascii = header_.order == PlyHeader::Order::ascii;
    allocate(ascii);
    if (ascii) {
      read_ascii();
    } else {
      for (const PlyElement& element : header_.elements) read_binary(element);
    }
    for (const PlyElement& element : header_.elements) {
      if (element.name != "face" || element.count == 0 || face_list_of(element) >= 0) continue;
      data_.warnings.push_back(
          "the element 'face' has no list 'vertex_indices' or "
          "'vertex_index': " +
          count_of(element.count, "face") + " left out");
    }
    faces_.finish(data_);
    header_.metadata.apply(data_);
    return std::move(data_);
  }

 private:
  void allocate(bool ascii);
  void read_binary(const PlyElement& element);
  void read_vertices(const PlyElement& element);
  bool read_plain_triangles(const PlyElement& element);
  void read_rows(const PlyElement& element);
  void read_list(const PlyElement& element, const PlyProperty& property, bool is_faces,
                 bool is_strips);
  void read_ascii();
  void read_ascii_row(TextScanner& scan, const PlyElement& element,
                      const std::vector<Column>& columns, int face_list, std::size_t row);
  void read_ascii_list(TextScanner& scan, bool is_faces, bool is_strips);
  void set(Column column, std::size_t row, float value);
  void add_face(bool is_strip);
  [[noreturn]] void fail(std::size_t byte, const std::string& what,
                         const std::string& remedy = {}) const {
    throw InputError(
        {.what = what, .file = name_, .place = "byte " + std::to_string(byte), .remedy = remedy});
  }
  void require(std::size_t bytes, const PlyElement& element, std::size_t row) const {
    if (bytes <= bytes_.size() - at_) return;
    fail(bytes_.size(),
         "the file ends within element '" + element.name + "', at row " + std::to_string(row) +
             " of " + std::to_string(element.count),
         "The file is damaged or incomplete");
  }
  static int face_list_of(const PlyElement& element) {
    if (element.name != "face" && element.name != "tristrips") return -1;
    for (const char* name : {"vertex_indices", "vertex_index"}) {
      const int i = element.find(name);
      if (i >= 0 && element.properties[static_cast<std::size_t>(i)].list) return i;
    }
    return -1;
  }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  PlyHeader header_;
  bool big_;
  std::size_t at_;
  MeshData data_;
  FaceCollector faces_;
  std::vector<int64_t> corners_;  ///< of the face being read, −1 ends a strip
  std::vector<VertexIndex> polygon_;
};

void PlyReader::allocate(bool ascii) {
  const PlyElement* vertex = nullptr;
  for (const PlyElement& e : header_.elements) {
    if (e.name != "vertex") continue;
    if (vertex != nullptr) fail(0, "the header has two elements 'vertex'");
    vertex = &e;
  }
  if (vertex == nullptr) fail(0, "the header has no element 'vertex'");
  const auto columns = columns_of(*vertex);
  for (const Column c : {Column::x, Column::y, Column::z}) {
    if (std::count(columns.begin(), columns.end(), c) != 1) {
      fail(0, "the element 'vertex' does not have the properties x, y and z once each");
    }
  }
  // Memory in proportion to the file: a text vertex takes six bytes at least ("0 0 0\n").
  const std::size_t least = ascii ? 2 * vertex->properties.size() : vertex->stride();
  if (vertex->count > (bytes_.size() - header_.size + 1) / least) {
    fail(bytes_.size(),
         "the header promises " + count_of(vertex->count, "vertex", "vertices") +
             ", but the file is too short for them",
         "The file is damaged or incomplete");
  }
  data_.allocate(1, vertex->count);
  const auto has = [&](Column c) {
    return std::find(columns.begin(), columns.end(), c) != columns.end();
  };
  if (has(Column::filled)) data_.filled = Buffer<uint8_t>(vertex->count, 0);
  if (has(Column::uncertainty)) data_.uncertainty = Buffer<float>(vertex->count, 0.0F);
}

void PlyReader::set(Column column, std::size_t row, float value) {
  switch (column) {
    case Column::skip: break;
    case Column::x: data_.positions[3 * row] = value; break;
    case Column::y: data_.positions[3 * row + 1] = value; break;
    case Column::z: data_.positions[3 * row + 2] = value; break;
    case Column::filled: data_.filled[row] = value != 0 ? 1 : 0; break;
    case Column::uncertainty: data_.uncertainty[row] = value; break;
  }
}

void PlyReader::read_binary(const PlyElement& element) {
  if (element.has_list()) {
    if (!read_plain_triangles(element)) read_rows(element);
  } else if (element.stride() > 0) {
    if (element.count > (bytes_.size() - at_) / element.stride()) {
      require(bytes_.size() - at_ + 1, element, (bytes_.size() - at_) / element.stride());
    }
    if (element.name == "vertex") read_vertices(element);
    at_ += element.count * element.stride();
  }
}

void PlyReader::read_vertices(const PlyElement& element) {
  const auto columns = columns_of(element);
  const std::size_t stride = element.stride();
  const std::byte* row = bytes_.data() + at_;
  const bool floats = std::all_of(element.properties.begin(), element.properties.end(),
                                  [](const PlyProperty& p) { return p.type == PlyType::f32; });
  if (floats && columns == std::vector{Column::x, Column::y, Column::z}) {
    if (big_) {
      copy_swapped(row, data_.positions.data(), data_.positions.size());
    } else {
      std::memcpy(data_.positions.data(), row, data_.positions.size() * sizeof(float));
    }
    return;
  }
  std::size_t offset = 0;
  for (std::size_t c = 0; c < columns.size(); ++c) {  // column by column: the type is settled once
    const PlyType type = element.properties[c].type;
    const std::byte* at = row + offset;
    offset += size_of(type);
    if (columns[c] == Column::skip) continue;
    if (columns[c] <= Column::z && type == PlyType::f32) {
      float* to = data_.positions.data() + (static_cast<int>(columns[c]) - 1);
      for (std::size_t i = 0; i < element.count; ++i)
        to[3 * i] = load_value<float>(at + i * stride, big_);
      continue;
    }
    for (std::size_t i = 0; i < element.count; ++i) {
      set(columns[c], i, static_cast<float>(value_as_double(at + i * stride, type, big_)));
    }
  }
}

/// Faces with nothing but a byte count and 32-bit indices, as nearly all are: as long as they are
/// triangles they are read here. False, with nothing read, for other layouts or at a polygon.
bool PlyReader::read_plain_triangles(const PlyElement& element) {
  if (element.name != "face" || element.properties.size() != 1) return false;
  const PlyProperty& p = element.properties[0];
  if (face_list_of(element) != 0 || p.count_type > PlyType::u8) return false;
  if (p.type != PlyType::i32 && p.type != PlyType::u32) return false;
  constexpr std::size_t stride = 13;
  if (element.count > (bytes_.size() - at_) / stride) return false;
  const std::byte* row = bytes_.data() + at_;
  const std::span<Triangle> out = faces_.grow(element.count);
  for (std::size_t f = 0; f < element.count; ++f, row += stride) {
    Triangle& t = out[f];
    std::memcpy(t.data(), row + 1, sizeof t);
    if (big_) t = {swap_bytes(t[0]), swap_bytes(t[1]), swap_bytes(t[2])};
    const bool inside = std::max({t[0], t[1], t[2]}) < data_.vertex_count;
    if (row[0] != std::byte{3} || !inside) {
      faces_.shrink(element.count);
      return false;  // the general way says what is wrong, if anything is
    }
  }
  at_ += element.count * stride;
  return true;
}

void PlyReader::read_rows(const PlyElement& element) {
  const int face_list = face_list_of(element);
  const auto columns = element.name == "vertex" ? columns_of(element) : std::vector<Column>{};
  if (face_list >= 0) faces_.reserve(std::min(element.count, (bytes_.size() - at_) / 4));
  for (std::size_t row = 0; row < element.count; ++row) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& p = element.properties[i];
      if (p.list) {
        require(size_of(p.count_type), element, row);
        const bool wanted = static_cast<int>(i) == face_list;
        read_list(element, p, wanted, wanted && element.name == "tristrips");
        continue;
      }
      require(size_of(p.type), element, row);
      if (!columns.empty()) {
        set(columns[i], row,
            static_cast<float>(value_as_double(bytes_.data() + at_, p.type, big_)));
      }
      at_ += size_of(p.type);
    }
  }
}

void PlyReader::read_list(const PlyElement& element, const PlyProperty& property, bool is_faces,
                          bool is_strips) {
  const int64_t count = value_as_index(bytes_.data() + at_, property.count_type, big_);
  if (count < 0) fail(at_, "the length of a list is negative");
  at_ += size_of(property.count_type);
  const std::size_t size = size_of(property.type);
  if (static_cast<std::size_t>(count) > (bytes_.size() - at_) / size) {
    fail(at_, "a list of element '" + element.name + "' has " + std::to_string(count) +
                  " values, more than the file has left");
  }
  if (is_faces) {
    corners_.clear();
    for (int64_t i = 0; i < count; ++i) {
      const std::size_t byte = at_ + static_cast<std::size_t>(i) * size;
      const int64_t v = value_as_index(bytes_.data() + byte, property.type, big_);
      if (v >= static_cast<int64_t>(data_.vertex_count) || (v < 0 && !is_strips)) {
        fail(byte, "a face refers to vertex " +
                       format_number(value_as_double(bytes_.data() + byte, property.type, big_)) +
                       " (0-based), but there are only " + std::to_string(data_.vertex_count));
      }
      corners_.push_back(v);
    }
    add_face(is_strips);
  }
  at_ += static_cast<std::size_t>(count) * size;
}

void PlyReader::add_face(bool is_strip) {
  if (!is_strip) {
    polygon_.assign(corners_.begin(), corners_.end());
    faces_.add(polygon_);
    return;
  }
  std::size_t begin = 0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    if (corners_[i] < 0) begin = i + 1;
    if (corners_[i] < 0 || i < begin + 2) continue;
    const bool odd = (i - begin) % 2 != 0;  // every second triangle of a strip is turned over
    Triangle t{static_cast<VertexIndex>(corners_[i - 2]), static_cast<VertexIndex>(corners_[i - 1]),
               static_cast<VertexIndex>(corners_[i])};
    if (odd) std::swap(t[0], t[1]);
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) faces_.add(t);
  }
}

void PlyReader::read_ascii() {
  TextScanner scan(text_of(bytes_), name_);
  scan.move_to(header_.size);
  for (const PlyElement& element : header_.elements) {
    if (element.properties.empty()) continue;
    const auto columns = element.name == "vertex" ? columns_of(element) : std::vector<Column>{};
    const int face_list = face_list_of(element);
    if (face_list >= 0)
      faces_.reserve(std::min(element.count, (bytes_.size() - scan.offset()) / 8));
    for (std::size_t row = 0; row < element.count; ++row) {
      scan.skip_space();
      if (scan.at_end()) {
        scan.fail("the file ends within element '" + element.name + "', at row " +
                      std::to_string(row) + " of " + std::to_string(element.count),
                  "The file is damaged or incomplete");
      }
      read_ascii_row(scan, element, columns, face_list, row);
      if (!scan.at_line_end()) {
        scan.fail("the line has more values than element '" + element.name + "' has properties");
      }
    }
  }
}

void PlyReader::read_ascii_row(TextScanner& scan, const PlyElement& element,
                               const std::vector<Column>& columns, int face_list, std::size_t row) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    if (element.properties[i].list) {
      const bool wanted = static_cast<int>(i) == face_list;
      read_ascii_list(scan, wanted, wanted && element.name == "tristrips");
    } else if (!columns.empty() && columns[i] != Column::skip) {
      set(columns[i], row, scan.number("a vertex's property"));
    } else if (scan.word().empty()) {
      scan.fail("the property '" + element.properties[i].name + "' is missing");
    }
  }
}

void PlyReader::read_ascii_list(TextScanner& scan, bool is_faces, bool is_strips) {
  const int64_t count = scan.integer("the length of a list");
  if (count < 0) scan.fail("the length of a list is negative");
  corners_.clear();
  for (int64_t i = 0; i < count; ++i) {
    if (!is_faces) {
      if (scan.word().empty()) scan.fail("the line is too short for its list");
      continue;
    }
    const int64_t v = scan.integer("a vertex index");
    if (v >= static_cast<int64_t>(data_.vertex_count) || (v < 0 && !is_strips)) {
      scan.fail("a face refers to vertex " + std::to_string(v) + " (0-based), but there are only " +
                std::to_string(data_.vertex_count));
    }
    corners_.push_back(v);
  }
  if (is_faces) add_face(is_strips);
}

}  // namespace

MeshData decode_ply(std::span<const std::byte> bytes, const std::string& name) {
  return PlyReader(bytes, name).read();
}

}  // namespace kinemesh
