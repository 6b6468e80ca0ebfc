#include "mesh/formats/npz.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <functional>
#include <numeric>

#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "mesh/formats/zip.h"

namespace kinemesh {
namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are written as they lie in memory");

constexpr std::string_view npy_magic("\x93NUMPY", 6);
constexpr std::size_t npy_alignment = 64;

std::size_t product(const std::vector<std::size_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

/// The header of a .npy file, version 1.0, padded so that the data starts at a multiple of 64.
std::string npy_header(std::string_view descr, const std::vector<std::size_t>& shape) {
  std::string dict = "{'descr': '" + std::string(descr) + "', 'fortran_order': False, 'shape': (";
  for (std::size_t i = 0; i < shape.size(); ++i) {
    if (i > 0) dict += ' ';
    dict += std::to_string(shape[i]) + (shape.size() == 1 || i + 1 < shape.size() ? "," : "");
  }
  dict += "), }";
  const std::size_t unpadded = npy_magic.size() + 4 + dict.size() + 1;
  dict.append((npy_alignment - unpadded % npy_alignment) % npy_alignment, ' ');
  dict += '\n';
  std::string header(npy_magic);
  header += '\1';
  header += '\0';
  header += static_cast<char>(dict.size() & 255U);
  header += static_cast<char>(dict.size() >> 8U);
  return header + dict;
}

/// Code points of UTF-8; bytes that are none are kept as the code point of their value (Latin-1).
std::u32string code_points(std::string_view text) {
  std::u32string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t more = lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : lead >= 0xC2 ? 1 : 0;
    char32_t c = more == 0 ? lead : lead & (0x3FU >> more);
    bool good = lead < 0x80 || (more > 0 && lead < 0xF5 && i + more < text.size());
    for (std::size_t k = 1; good && k <= more; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      good = (next & 0xC0U) == 0x80U;
      c = (c << 6U) | (next & 0x3FU);
    }
    good = good && c < 0x110000 && (c < 0xD800 || c > 0xDFFF);
    out += good ? c : char32_t{lead};
    i += good ? more + 1 : 1;
  }
  return out;
}

void append_utf8(std::string& out, uint32_t c) {
  const auto tail = [&out, c](unsigned shift) {
    out += static_cast<char>(0x80U | ((c >> shift) & 0x3FU));
  };
  if (c < 0x80) {
    out += static_cast<char>(c);
  } else if (c < 0x800) {
    out += static_cast<char>(0xC0U | (c >> 6U));
    tail(0);
  } else if (c < 0x10000) {
    out += static_cast<char>(0xE0U | (c >> 12U));
    tail(6);
    tail(0);
  } else {
    out += static_cast<char>(0xF0U | ((c >> 18U) & 7U));
    tail(12);
    tail(6);
    tail(0);
  }
}

std::size_t size_of(NpyType type) {
  switch (type) {
    case NpyType::float64:
    case NpyType::int64: return 8;
    case NpyType::float32:
    case NpyType::int32: return 4;
    default: return 1;
  }
}

/// Reads one .npy file.
class NpyParser {
 public:
  NpyParser(std::string_view content, std::string name, std::string file)
      : content_(content), name_(std::move(name)), file_(std::move(file)) {}

  NpyArray parse() {
    read_header();
    NpyArray array;
    array.shape = shape();
    const std::string descr = quoted_after("descr");
    const std::size_t item = item_size(descr, array);
    std::size_t bytes = item;
    for (const std::size_t extent : array.shape) {
      if (extent != 0 && bytes > content_.size() / extent) refuse("it is cut off");
      bytes *= extent;
    }
    if (content_.size() - data_ < bytes) refuse("it is cut off");
    const std::string_view data = content_.substr(data_, bytes);
    if (array.type == NpyType::text) {
      read_texts(array, data, item, descr[1] == 'U');
    } else {
      array.bytes = data;
    }
    return array;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError({.what = what, .file = file_, .place = "array '" + name_ + "'"});
  }

  void read_header() {
    if (content_.size() < 12 || content_.substr(0, 6) != npy_magic)
      refuse("this is no NumPy array");
    const auto byte = [this](std::size_t i) { return static_cast<unsigned char>(content_[i]); };
    const bool short_length = byte(6) == 1;
    std::size_t length = byte(8) | static_cast<std::size_t>(byte(9)) << 8U;
    if (!short_length) {
      length |= static_cast<std::size_t>(byte(10)) << 16U | static_cast<std::size_t>(byte(11))
                                                                << 24U;
    }
    const std::size_t start = short_length ? 10 : 12;
    if (content_.size() - start < length) refuse("its header is cut off");
    header_ = content_.substr(start, length);
    data_ = start + length;
    if (header_.find("'fortran_order': True") != std::string_view::npos && shape().size() > 1) {
      refuse("it is stored in Fortran order; save numpy.ascontiguousarray(…) of it instead");
    }
  }

  std::size_t value_of(std::string_view key) const {
    const std::size_t at = header_.find("'" + std::string(key) + "'");
    const std::size_t colon = at == std::string_view::npos ? at : header_.find(':', at);
    if (colon == std::string_view::npos)
      refuse("its header does not say '" + std::string(key) + "'");
    return colon + 1;
  }

  std::string quoted_after(std::string_view key) const {
    const std::size_t open = header_.find('\'', value_of(key));
    const std::size_t close = open == std::string_view::npos ? open : header_.find('\'', open + 1);
    if (close == std::string_view::npos) refuse("its element type is not supported");
    return std::string(header_.substr(open + 1, close - open - 1));
  }

  std::vector<std::size_t> shape() const {
    const std::size_t open = header_.find('(', value_of("shape"));
    const std::size_t close = header_.find(')', value_of("shape"));
    if (open == std::string_view::npos || close == std::string_view::npos || close < open) {
      refuse("its header gives no shape");
    }
    std::vector<std::size_t> extents;
    const char* at = header_.data() + open + 1;
    const char* const end = header_.data() + close;
    while (at < end) {
      if (*at == ' ' || *at == ',') {
        ++at;
        continue;
      }
      std::size_t extent = 0;
      const auto [next, error] = std::from_chars(at, end, extent);
      if (error != std::errc{} || extents.size() == 32) refuse("its shape cannot be read");
      extents.push_back(extent);
      at = next;
    }
    return extents;
  }

  std::size_t item_size(const std::string& descr, NpyArray& array) const {
    static const std::map<std::string, NpyType, std::less<>> types = {
        {"<f4", NpyType::float32}, {"<f8", NpyType::float64}, {"<i4", NpyType::int32},
        {"<i8", NpyType::int64},   {"|u1", NpyType::uint8},   {"|b1", NpyType::boolean}};
    if (const auto it = types.find(descr); it != types.end()) {
      array.type = it->second;
      return size_of(it->second);
    }
    if (descr.starts_with("<U") || descr.starts_with("|S")) {
      std::size_t width = 0;
      const auto result = std::from_chars(descr.data() + 2, descr.data() + descr.size(), width);
      if (result.ec == std::errc{} && width <= content_.size()) {
        array.type = NpyType::text;
        return descr[1] == 'U' ? 4 * width : width;
      }
    }
    refuse("elements of the type '" + descr + "' are not supported");
  }

  void read_texts(NpyArray& array, std::string_view data, std::size_t item, bool unicode) const {
    const std::size_t count = array.size();
    if (item == 0 && count > content_.size()) refuse("it is cut off");
    array.texts.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view raw = data.substr(i * item, item);
      std::string& text = array.texts[i];
      if (!unicode) {
        text = raw.substr(0, raw.find_last_not_of('\0') + 1);
        continue;
      }
      std::size_t used = item / 4;
      const auto code = [&raw](std::size_t k) {
        uint32_t c = 0;
        std::memcpy(&c, raw.data() + 4 * k, 4);
        return c;
      };
      while (used > 0 && code(used - 1) == 0) --used;
      for (std::size_t k = 0; k < used; ++k) append_utf8(text, code(k));
    }
  }

  std::string_view content_;
  std::string name_, file_;
  std::string_view header_;
  std::size_t data_ = 0;
};

template <class T>
void append_numbers(std::vector<double>& out, std::string_view bytes) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    out.push_back(static_cast<double>(value));
  }
}

}  // namespace

std::size_t NpyArray::size() const { return product(shape); }

std::vector<double> NpyArray::numbers() const {
  std::vector<double> out;
  out.reserve(size());
  switch (type) {
    case NpyType::float32: append_numbers<float>(out, bytes); break;
    case NpyType::float64: append_numbers<double>(out, bytes); break;
    case NpyType::int32: append_numbers<int32_t>(out, bytes); break;
    case NpyType::int64: append_numbers<int64_t>(out, bytes); break;
    case NpyType::uint8:
    case NpyType::boolean: append_numbers<uint8_t>(out, bytes); break;
    case NpyType::text: throw InputError({.what = "the array holds texts, not numbers"});
  }
  return out;
}

void NpzWriter::add_member(std::string_view name, std::string_view descr,
                           const std::vector<std::size_t>& shape, const void* data,
                           std::size_t bytes) {
  std::string member = std::string(name) + ".npy";
  if (std::ranges::any_of(members_, [&](const Member& m) { return m.name == member; })) {
    throw InternalError("the array '" + std::string(name) + "' is added twice");
  }
  std::string content = npy_header(descr, shape);
  if (bytes > 0) content.append(static_cast<const char*>(data), bytes);
  members_.push_back({std::move(member), std::move(content)});
}

namespace {

void check_size(std::string_view name, const std::vector<std::size_t>& shape, std::size_t size) {
  if (product(shape) != size) {
    throw InternalError("the array '" + std::string(name) + "' has " + std::to_string(size) +
                        " values, but its shape asks for " + std::to_string(product(shape)));
  }
}

}  // namespace

void NpzWriter::add(std::string_view name, const std::vector<std::size_t>& shape,
                    std::span<const float> values) {
  check_size(name, shape, values.size());
  add_member(name, "<f4", shape, values.data(), values.size_bytes());
}

void NpzWriter::add(std::string_view name, const std::vector<std::size_t>& shape,
                    std::span<const double> values) {
  check_size(name, shape, values.size());
  add_member(name, "<f8", shape, values.data(), values.size_bytes());
}

void NpzWriter::add(std::string_view name, const std::vector<std::size_t>& shape,
                    std::span<const int32_t> values) {
  check_size(name, shape, values.size());
  add_member(name, "<i4", shape, values.data(), values.size_bytes());
}

void NpzWriter::add(std::string_view name, const std::vector<std::size_t>& shape,
                    std::span<const int64_t> values) {
  check_size(name, shape, values.size());
  add_member(name, "<i8", shape, values.data(), values.size_bytes());
}

void NpzWriter::add(std::string_view name, const std::vector<std::size_t>& shape,
                    std::span<const uint8_t> values) {
  check_size(name, shape, values.size());
  add_member(name, "|u1", shape, values.data(), values.size_bytes());
}

void NpzWriter::add_booleans(std::string_view name, const std::vector<std::size_t>& shape,
                             std::span<const uint8_t> values) {
  check_size(name, shape, values.size());
  std::string bytes(values.size(), '\0');
  std::ranges::transform(values, bytes.begin(), [](uint8_t v) { return v != 0 ? '\1' : '\0'; });
  add_member(name, "|b1", shape, bytes.data(), bytes.size());
}

void NpzWriter::add(std::string_view name, std::span<const std::string> texts) {
  std::vector<std::u32string> wide;
  wide.reserve(texts.size());
  std::size_t width = 1;  // NumPy itself never writes an item size of 0
  for (const std::string& text : texts) {
    wide.push_back(code_points(text));
    width = std::max(width, wide.back().size());
  }
  std::u32string all;
  all.reserve(width * texts.size());
  for (std::u32string& text : wide) {
    text.resize(width, U'\0');
    all += text;
  }
  add_member(name, "<U" + std::to_string(width), {texts.size()}, all.data(), 4 * all.size());
}

void NpzWriter::add(std::string_view name, double value) {
  add_member(name, "<f8", {}, &value, sizeof value);
}

void NpzWriter::add(std::string_view name, std::string_view text) {
  const std::u32string wide = code_points(text);
  const std::u32string item = wide.empty() ? std::u32string(1, U'\0') : wide;
  add_member(name, "<U" + std::to_string(item.size()), {}, item.data(), 4 * item.size());
}

std::string NpzWriter::bytes() const {
  std::vector<ZipMember> members;
  members.reserve(members_.size());
  for (const Member& m : members_) members.push_back({m.name, m.content});
  return zip_of(members);
}

void NpzWriter::write(const std::filesystem::path& path) const { write_file(path, bytes()); }

NpzFile read_npz(const std::filesystem::path& path) {
  return parse_npz(read_file(path), path.string());
}

NpzFile parse_npz(std::string_view content, const std::string& archive) {
  NpzFile file;
  if (content.starts_with(npy_magic)) {
    file.emplace("array", NpyParser(content, "array", archive).parse());
    return file;
  }
  for (const ZipMember& member : zip_members(content, archive)) {
    std::string name = member.name;
    if (name.ends_with(".npy")) name.resize(name.size() - 4);
    file.emplace(name, NpyParser(member.content, name, archive).parse());
  }
  return file;
}

const NpyArray& npz_array(const NpzFile& file, std::string_view name) {
  const auto it = file.find(name);
  if (it == file.end()) {
    throw InputError({.what = "the archive has no array '" + std::string(name) + "'"});
  }
  return it->second;
}

}  // namespace kinemesh
