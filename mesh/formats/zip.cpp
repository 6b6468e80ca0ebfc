#include "mesh/formats/zip.h"

#include <array>
#include <limits>

#include "config/error.h"

namespace kinemesh {
namespace {

constexpr uint32_t local_signature = 0x04034b50;
constexpr uint32_t central_signature = 0x02014b50;
constexpr uint32_t end_signature = 0x06054b50;
constexpr std::size_t local_size = 30;
constexpr std::size_t central_size = 46;
constexpr std::size_t end_size = 22;
constexpr uint16_t utf8_names = 0x0800;
constexpr uint16_t date_1980_01_01 = 0x0021;  // no clock: the same members, the same bytes

void put16(std::string& out, uint16_t v) {
  out += static_cast<char>(v & 255U);
  out += static_cast<char>(v >> 8U);
}

void put32(std::string& out, uint32_t v) {
  put16(out, static_cast<uint16_t>(v & 65535U));
  put16(out, static_cast<uint16_t>(v >> 16U));
}

uint16_t get16(std::string_view in, std::size_t at) {
  return static_cast<uint16_t>(static_cast<unsigned char>(in[at]) |
                               static_cast<unsigned char>(in[at + 1]) << 8U);
}

uint32_t get32(std::string_view in, std::size_t at) {
  return get16(in, at) | static_cast<uint32_t>(get16(in, at + 2)) << 16U;
}

std::array<std::array<uint32_t, 256>, 8> make_crc_tables() {
  std::array<std::array<uint32_t, 256>, 8> tables{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1U) : c >> 1U;
    tables[0][i] = c;
  }
  for (uint32_t i = 0; i < 256; ++i) {
    for (std::size_t t = 1; t < 8; ++t) {
      tables[t][i] = tables[0][tables[t - 1][i] & 255U] ^ (tables[t - 1][i] >> 8U);
    }
  }
  return tables;
}

/// Fields that the local and the central header share: version to the length of the extra field.
void put_common(std::string& out, const ZipMember& member, uint32_t crc) {
  put16(out, 20);  // version needed
  put16(out, utf8_names);
  put16(out, 0);  // stored
  put16(out, 0);
  put16(out, date_1980_01_01);
  put32(out, crc);
  put32(out, static_cast<uint32_t>(member.content.size()));
  put32(out, static_cast<uint32_t>(member.content.size()));
  put16(out, static_cast<uint16_t>(member.name.size()));
  put16(out, 0);
}

[[noreturn]] void refuse(const std::string& file, std::size_t at, const std::string& what,
                         const std::string& remedy = "") {
  throw InputError(
      {.what = what, .file = file, .place = "byte " + std::to_string(at), .remedy = remedy});
}

std::size_t find_end(std::string_view archive, const std::string& file) {
  // The record lies at the end, before a comment of at most 65,535 bytes.
  if (archive.size() >= end_size) {
    const std::size_t last = archive.size() - end_size;
    for (std::size_t back = 0; back <= last && back <= 65535; ++back) {
      if (get32(archive, last - back) == end_signature) return last - back;
    }
  }
  refuse(file, archive.size(), "this is no complete archive: its table of contents is missing",
         "Copy the file again");
}

/// `left`: bytes that the members not read yet may take.
ZipMember read_member(std::string_view archive, std::size_t at, std::size_t& left,
                      const std::string& file) {
  const std::size_t name_size = get16(archive, at + 28);
  if (at + central_size + name_size > archive.size()) refuse(file, at, "the archive is cut off");
  ZipMember member{.name = std::string(archive.substr(at + central_size, name_size)),
                   .content = {}};
  if ((get16(archive, at + 8) & 1U) != 0) refuse(file, at, "'" + member.name + "' is encrypted");
  if (get16(archive, at + 10) != 0) {
    refuse(file, at, "'" + member.name + "' is compressed",
           "Write it uncompressed: numpy.savez instead of numpy.savez_compressed");
  }
  const std::size_t size = get32(archive, at + 24);
  const std::size_t start = get32(archive, at + 42);
  if (size == 0xFFFFFFFFU || start == 0xFFFFFFFFU)
    refuse(file, at, "archives over 4 GiB are not read");
  if (start + local_size > archive.size() || get32(archive, start) != local_signature) {
    refuse(file, at, "'" + member.name + "' lies outside the file");
  }
  const std::size_t content =
      start + local_size + get16(archive, start + 26) + get16(archive, start + 28);
  if (content + size > archive.size()) refuse(file, start, "'" + member.name + "' is cut off");
  if (size > left) refuse(file, at, "the members share data: they are larger than the archive");
  left -= size;
  member.content = archive.substr(content, size);
  if (crc32_of(member.content) != get32(archive, at + 16)) {
    refuse(file, content, "'" + member.name + "' is damaged: its checksum does not match",
           "Copy the file again");
  }
  return member;
}

}  // namespace

uint32_t crc32_of(std::string_view bytes) {
  static const auto tables = make_crc_tables();
  uint32_t c = 0xFFFFFFFFU;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {  // eight bytes a step ("slicing by 8")
    const uint32_t low = c ^ get32(bytes, i);
    const uint32_t high = get32(bytes, i + 4);
    c = tables[7][low & 255U] ^ tables[6][(low >> 8U) & 255U] ^ tables[5][(low >> 16U) & 255U] ^
        tables[4][low >> 24U] ^ tables[3][high & 255U] ^ tables[2][(high >> 8U) & 255U] ^
        tables[1][(high >> 16U) & 255U] ^ tables[0][high >> 24U];
  }
  for (; i < bytes.size(); ++i) {
    c = tables[0][(c ^ static_cast<unsigned char>(bytes[i])) & 255U] ^ (c >> 8U);
  }
  return c ^ 0xFFFFFFFFU;
}

std::string zip_of(const std::vector<ZipMember>& members) {
  std::size_t total = end_size;
  for (const ZipMember& m : members) {
    total += local_size + central_size + 2 * m.name.size() + m.content.size();
  }
  if (total >= std::numeric_limits<uint32_t>::max() || members.size() > 65535) {
    throw InputError({.what = "an archive of more than 4 GiB cannot be written",
                      .remedy = "Export fewer frames or markers"});
  }
  std::string out;
  out.reserve(total);
  std::string central;
  for (const ZipMember& m : members) {
    const auto start = static_cast<uint32_t>(out.size());
    const uint32_t crc = crc32_of(m.content);
    put32(out, local_signature);
    put_common(out, m, crc);
    out.append(m.name).append(m.content);
    put32(central, central_signature);
    put16(central, 20);  // made by
    put_common(central, m, crc);
    put16(central, 0);  // comment
    put16(central, 0);  // disk
    put16(central, 0);  // internal attributes
    put32(central, 0);  // external attributes
    put32(central, start);
    central.append(m.name);
  }
  const auto central_start = static_cast<uint32_t>(out.size());
  out += central;
  put32(out, end_signature);
  put32(out, 0);  // disks
  put16(out, static_cast<uint16_t>(members.size()));
  put16(out, static_cast<uint16_t>(members.size()));
  put32(out, static_cast<uint32_t>(central.size()));
  put32(out, central_start);
  put16(out, 0);  // comment
  return out;
}

std::vector<ZipMember> zip_members(std::string_view archive, const std::string& file) {
  const std::size_t end = find_end(archive, file);
  const std::size_t count = get16(archive, end + 10);
  std::size_t at = get32(archive, end + 16);
  std::vector<ZipMember> members;
  std::size_t left = archive.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (at + central_size > end || get32(archive, at) != central_signature) {
      refuse(file, at, "the archive's table of contents is damaged", "Copy the file again");
    }
    members.push_back(read_member(archive, at, left, file));
    at +=
        central_size + get16(archive, at + 28) + get16(archive, at + 30) + get16(archive, at + 32);
  }
  return members;
}

}  // namespace kinemesh
