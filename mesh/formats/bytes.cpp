#include "mesh/formats/bytes.h"

#include "config/error.h"
#include "config/input_file.h"
#include "config/multiversion.h"
#include "config/text.h"

namespace kinemesh {

Buffer<std::byte> load_bytes(const std::filesystem::path& path) {
  const InputFile file(path);
  Buffer<std::byte> bytes(file.size());
  if (file.read_at(0, bytes.data(), bytes.size()) != bytes.size()) {
    throw InputError({.what = "the file became shorter while it was read", .file = path.string()});
  }
  return bytes;
}

KINEMESH_MULTIVERSION void copy_swapped(const void* from, float* to, std::size_t count) {
  const auto* source = static_cast<const unsigned char*>(from);
  for (std::size_t i = 0; i < count; ++i) {
    uint32_t bits = 0;
    std::memcpy(&bits, source + 4 * i, sizeof bits);
    bits = __builtin_bswap32(bits);
    std::memcpy(to + i, &bits, sizeof bits);
  }
}

std::span<const std::byte> ByteReader::take(std::size_t count) {
  require(count);
  const auto taken = bytes_.subspan(position_, count);
  position_ += count;
  return taken;
}

void ByteReader::require(std::size_t count) const {
  if (count <= remaining()) return;
  throw InputError({.what = "the file ends here, but " + count_of(count, "byte") +
                            " should follow (" + std::to_string(remaining()) + " are left)",
                    .file = name_,
                    .place = "byte " + std::to_string(position_),
                    .remedy = "The file is damaged or incomplete"});
}

void ByteReader::fail(const std::string& what) const {
  throw InputError({.what = what, .file = name_, .place = "byte " + std::to_string(position_)});
}

}  // namespace kinemesh
