// Archives of uncompressed members (ZIP, PKWARE APPNOTE 6.3, method "stored"), as .npz uses them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

struct ZipMember {
  std::string name;
  std::string_view content;
};

/// CRC-32 as in ZIP and PNG (polynomial 0xEDB88320); crc32_of("123456789") is 0xCBF43926.
uint32_t crc32_of(std::string_view bytes);

/// The archive; the same members give the same bytes. Throws InputError beyond 4 GiB or 65,535
/// members.
std::string zip_of(const std::vector<ZipMember>& members);

/// The members of an archive; the contents are views into `archive`. Throws InputError with
/// `file` and the byte for damaged, compressed, encrypted or ZIP64 archives.
std::vector<ZipMember> zip_members(std::string_view archive, const std::string& file);

}  // namespace kinemesh
