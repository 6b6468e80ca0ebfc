#include "mesh/formats/vtk_array.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/text_scanner.h"

namespace kinemesh {
namespace {

[[noreturn]] void fail(const VtkFile& file, const XmlElement& array, const std::string& what,
                       const std::string& remedy = {}) {
  const std::string* name = array.attribute("Name");
  throw InputError({.what = what,
                    .file = file.name,
                    .place = "array '" + (name != nullptr ? *name : std::string()) + "' at byte " +
                             std::to_string(array.text_begin),
                    .remedy = remedy});
}

std::string type_of(const XmlElement& array) {
  const std::string* type = array.attribute("type");
  return type != nullptr ? *type : "Float32";
}

bool is_ascii(const XmlElement& array) {
  const std::string* format = array.attribute("format");
  return format == nullptr || *format == "ascii";
}

std::size_t header_value(const VtkFile& file, std::string_view bytes, std::size_t i) {
  const char* at = bytes.data() + i * file.header_bytes;
  return file.header_bytes == 8 ? load_value<uint64_t>(at, file.big_endian)
                                : load_value<uint32_t>(at, file.big_endian);
}

/// Bytes of one array, encoded: base64 or raw, from its beginning to the end of the file.
class Stream {
 public:
  Stream(const VtkFile& file, const XmlElement& array, std::string_view content, bool base64)
      : file_(file), array_(array), content_(content), base64_(base64) {}

  /// The bytes [begin, begin + count), base64 decoded. `groups` lists the lengths after which
  /// padding may stand; decoding by groups of four skips it anyway.
  std::string_view take(std::size_t begin, std::size_t count) {
    if (count > content_.size() || begin > content_.size() - count) ends();
    if (!base64_) return content_.substr(begin, count);
    if (decoded_.size() < begin + count) decoded_ = decode_base64(content_, begin + count);
    if (decoded_.size() < begin + count) ends();
    return std::string_view(decoded_).substr(begin, count);
  }

 private:
  [[noreturn]] void ends() const {
    fail(file_, array_, "the file ends within the data", "The file is damaged or incomplete");
  }

  const VtkFile& file_;
  const XmlElement& array_;
  std::string_view content_;
  bool base64_;
  std::string decoded_;
};

std::string inflate_blocks(const VtkFile& file, const XmlElement& array, Stream& stream) {
  const std::size_t word = file.header_bytes;
  const std::size_t blocks = header_value(file, stream.take(0, word), 0);
  if (blocks == 0) return {};
  if (blocks > (std::size_t{1} << 40)) fail(file, array, "the number of blocks is too large");
  const std::string header(stream.take(0, (3 + blocks) * word));
  const std::size_t block_size = header_value(file, header, 1);
  const std::size_t partial = header_value(file, header, 2);
  std::size_t total = header.size();
  for (std::size_t b = 0; b < blocks; ++b) {
    total += std::min(header_value(file, header, 3 + b), std::size_t{1} << 40);
  }
  stream.take(0, total);  // decoded once
  std::string out;
  std::size_t at = header.size();
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t packed = header_value(file, header, 3 + b);
    const std::size_t size = b + 1 == blocks && partial != 0 ? partial : block_size;
    const std::string_view bytes = stream.take(at, packed);
    // zlib packs at most 1032 to 1: what promises more is damaged and gets no memory.
    if (size / 1100 > packed) fail(file, array, "a compressed block promises too many bytes");
    const std::size_t before = out.size();
    out.resize(before + size);
    uLongf got = size;
    if (uncompress(reinterpret_cast<Bytef*>(out.data() + before), &got,
                   reinterpret_cast<const Bytef*>(bytes.data()), packed) != Z_OK ||
        got != size) {
      fail(file, array, "block " + std::to_string(b) + " cannot be decompressed",
           "The file is damaged");
    }
    at += packed;
  }
  return out;
}

/// The array's bytes as they lay in memory, in the file's byte order.
std::string binary_bytes(const VtkFile& file, const XmlElement& array) {
  const bool appended = *array.attribute("format") == "appended";
  std::string_view content = array.text;
  if (appended) {
    const std::string* text = array.attribute("offset");
    std::size_t offset = 0;
    if (text == nullptr ||
        std::from_chars(text->data(), text->data() + text->size(), offset).ec != std::errc()) {
      fail(file, array, "the array has no offset into the appended data");
    }
    if (offset > file.appended.size()) {
      fail(file, array, "the offset lies behind the end of the appended data",
           "The file is damaged or incomplete");
    }
    content = file.appended.substr(offset);
  }
  Stream stream(file, array, content, !appended || file.appended_base64);
  if (file.compressed) return inflate_blocks(file, array, stream);
  const std::size_t bytes = header_value(file, stream.take(0, file.header_bytes), 0);
  if (bytes > content.size())
    fail(file, array, "the file ends within the data", "The file is damaged or incomplete");
  return std::string(stream.take(file.header_bytes, bytes));
}

template <class Out, class T>
void convert(const VtkFile& file, std::string_view bytes, std::vector<Out>& out) {
  out.resize(bytes.size() / sizeof(T));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = static_cast<Out>(load_value<T>(bytes.data() + i * sizeof(T), file.big_endian));
  }
}

template <class Out>
std::vector<Out> numbers_of(const VtkFile& file, const XmlElement& array) {
  std::vector<Out> out;
  if (is_ascii(array)) {
    TextScanner scan(array.text, file.name);
    for (scan.skip_space(); !scan.at_end(); scan.skip_space()) {
      if constexpr (std::is_same_v<Out, float>) {
        out.push_back(scan.number("a value"));
      } else {
        out.push_back(scan.real("a value"));
      }
    }
    return out;
  }
  const std::string bytes = binary_bytes(file, array);
  const std::string type = type_of(array);
  if (type == "Float32") {
    convert<Out, float>(file, bytes, out);
  } else if (type == "Float64") {
    convert<Out, double>(file, bytes, out);
  } else if (type == "Int8") {
    convert<Out, int8_t>(file, bytes, out);
  } else if (type == "UInt8") {
    convert<Out, uint8_t>(file, bytes, out);
  } else if (type == "Int16") {
    convert<Out, int16_t>(file, bytes, out);
  } else if (type == "UInt16") {
    convert<Out, uint16_t>(file, bytes, out);
  } else if (type == "Int32") {
    convert<Out, int32_t>(file, bytes, out);
  } else if (type == "UInt32") {
    convert<Out, uint32_t>(file, bytes, out);
  } else if (type == "Int64") {
    convert<Out, int64_t>(file, bytes, out);
  } else if (type == "UInt64") {
    convert<Out, uint64_t>(file, bytes, out);
  } else {
    fail(file, array, "the type '" + type + "' is not known");
  }
  return out;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

VtkFile vtk_file_of(const XmlElement& root, const std::string& name) {
  VtkFile file;
  file.name = name;
  if (root.name != "VTKFile") {
    throw InputError(
        {.what = "this is no VTK XML file: its root is <" + root.name + ">", .file = name});
  }
  const std::string* order = root.attribute("byte_order");
  file.big_endian = order != nullptr && *order == "BigEndian";
  const std::string* header = root.attribute("header_type");
  file.header_bytes = header != nullptr && *header == "UInt64" ? 8 : 4;
  const std::string* compressor = root.attribute("compressor");
  file.compressed = compressor != nullptr && !compressor->empty();
  if (file.compressed && *compressor != "vtkZLibDataCompressor") {
    throw InputError({.what = "the compressor " + *compressor + " is not read",
                      .file = name,
                      .remedy = "Save it with zlib or without compression"});
  }
  if (const XmlElement* appended = root.child("AppendedData")) {
    const std::string* encoding = appended->attribute("encoding");
    file.appended_base64 = encoding != nullptr && *encoding == "base64";
    const std::size_t mark = appended->text.find('_');
    if (mark != std::string_view::npos) file.appended = appended->text.substr(mark + 1);
  }
  return file;
}

std::vector<double> vtk_numbers(const VtkFile& file, const XmlElement& array) {
  return numbers_of<double>(file, array);
}

std::vector<float> vtk_floats(const VtkFile& file, const XmlElement& array) {
  return numbers_of<float>(file, array);
}

std::vector<std::string> vtk_texts(const VtkFile& file, const XmlElement& array) {
  std::string bytes;
  if (is_ascii(array)) {
    for (const double code : numbers_of<double>(file, array)) {
      if (!(code >= 0 && code < 256)) fail(file, array, "a character code is not below 256");
      bytes += static_cast<char>(static_cast<unsigned char>(code));
    }
  } else {
    bytes = binary_bytes(file, array);
  }
  std::vector<std::string> texts;
  for (std::size_t begin = 0; begin < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\0', begin), bytes.size());
    texts.push_back(bytes.substr(begin, end - begin));
    begin = end + 1;
  }
  return texts;
}

std::string decode_base64(std::string_view text, std::size_t max_bytes) {
  std::string out;
  out.reserve(std::min(max_bytes, text.size() / 4 * 3) + 3);
  std::array<int, 4> group{};
  int filled = 0;
  int padding = 0;
  for (const char c : text) {
    if (out.size() >= max_bytes) break;
    if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
    const int digit = c == '=' ? 0 : base64_digit(c);
    if (digit < 0) break;
    padding += c == '=' ? 1 : 0;
    group[static_cast<std::size_t>(filled++)] = digit;
    if (filled < 4) continue;
    const int bits = group[0] << 18 | group[1] << 12 | group[2] << 6 | group[3];
    const std::array<char, 3> three{static_cast<char>(bits >> 16), static_cast<char>(bits >> 8),
                                    static_cast<char>(bits)};
    out.append(three.data(), static_cast<std::size_t>(std::max(0, 3 - padding)));
    filled = padding = 0;
  }
  return out;
}

}  // namespace kinemesh
