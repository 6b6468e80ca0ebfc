#include "mesh/formats/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "mesh/formats/text_scanner.h"

namespace kinemesh {
namespace {

std::optional<PlyType> type_of(std::string_view word) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> words{{
      {"float", PlyType::f32},
      {"float32", PlyType::f32},
      {"uchar", PlyType::u8},
      {"uint8", PlyType::u8},
      {"int", PlyType::i32},
      {"int32", PlyType::i32},
      {"uint", PlyType::u32},
      {"uint32", PlyType::u32},
      {"double", PlyType::f64},
      {"float64", PlyType::f64},
      {"char", PlyType::i8},
      {"int8", PlyType::i8},
      {"short", PlyType::i16},
      {"int16", PlyType::i16},
      {"ushort", PlyType::u16},
      {"uint16", PlyType::u16},
  }};
  for (const auto& [text, type] : words) {
    if (text == word) return type;
  }
  return std::nullopt;
}

PlyType read_type(TextScanner& scan) {
  const std::string_view word = scan.word();
  const auto type = type_of(word);
  if (!type) scan.fail("'" + std::string(word.substr(0, 40)) + "' is no type of a property");
  return *type;
}

void read_format(TextScanner& scan, PlyHeader& header) {
  const std::string_view word = scan.word();
  if (word == "ascii") {
    header.order = PlyHeader::Order::ascii;
  } else if (word == "binary_little_endian") {
    header.order = PlyHeader::Order::little;
  } else if (word == "binary_big_endian") {
    header.order = PlyHeader::Order::big;
  } else {
    scan.fail("the format '" + std::string(word.substr(0, 40)) +
              "' is none of ascii, binary_little_endian and binary_big_endian");
  }
}

void read_element(TextScanner& scan, PlyHeader& header) {
  PlyElement element;
  element.name = scan.word();
  const int64_t count = scan.integer("the number of elements");
  if (count < 0) scan.fail("the number of elements is negative");
  element.count = static_cast<std::size_t>(count);
  header.elements.push_back(std::move(element));
}

void read_property(TextScanner& scan, PlyHeader& header) {
  if (header.elements.empty()) scan.fail("a property stands before the first element");
  PlyProperty property;
  const std::size_t before = scan.offset();
  if (scan.word() == "list") {
    property.list = true;
    property.count_type = read_type(scan);
    if (property.count_type >= PlyType::f32) scan.fail("the length of a list must be an integer");
  } else {
    scan.move_to(before);
  }
  property.type = read_type(scan);
  property.name = scan.word();
  if (property.name.empty()) scan.fail("the property has no name");
  header.elements.back().properties.push_back(std::move(property));
}

}  // namespace

std::size_t size_of(PlyType type) {
  static constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

bool PlyElement::has_list() const {
  return std::any_of(properties.begin(), properties.end(), [](const auto& p) { return p.list; });
}

std::size_t PlyElement::stride() const {
  std::size_t bytes = 0;
  for (const PlyProperty& p : properties) bytes += p.list ? 0 : size_of(p.type);
  return bytes;
}

int PlyElement::find(std::string_view property) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property) return static_cast<int>(i);
  }
  return -1;
}

PlyHeader parse_ply_header(std::string_view text, const std::string& name) {
  TextScanner scan(text, name);
  if (scan.word() != "ply") scan.fail("this is no PLY file: it does not begin with 'ply'");
  scan.next_line();
  PlyHeader header;
  bool format_seen = false;
  for (;; scan.next_line()) {
    if (scan.at_end()) scan.fail("the header has no end: the line 'end_header' is missing");
    const std::string_view key = scan.word();
    if (key == "end_header") break;
    if (key == "format") {
      read_format(scan, header);
      format_seen = true;
    } else if (key == "comment") {
      header.metadata.read(scan.rest_of_line());
    } else if (key == "element") {
      read_element(scan, header);
    } else if (key == "property") {
      read_property(scan, header);
    } else if (key != "obj_info" && !key.empty()) {
      scan.fail("the header line begins with '" + std::string(key.substr(0, 40)) +
                "', which is no word of PLY");
    }
  }
  if (!format_seen) scan.fail("the header does not say its format");
  scan.next_line();
  header.size = scan.offset();
  return header;
}

}  // namespace kinemesh
