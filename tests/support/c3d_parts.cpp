#include "tests/support/c3d_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "capture/c3d/header_block.h"
#include "capture/c3d/parameter_section.h"
#include "tests/support/c3d_takes.h"

namespace kinemesh::test {

C3dParts take_apart(const std::string& bytes) {
  const C3dReadResult r = read_encoded(bytes);
  return {.processor = r.layout.processor,
          .header = r.header,
          .parameters = r.take.parameters,
          .data = bytes.substr(r.layout.data_begin)};
}

std::string put_together(C3dParts parts, bool place_data) {
  std::vector<std::string> losses;
  std::string section = encode_section(parts.parameters, parts.processor, losses);
  if (place_data) {
    const std::size_t block = 2 + section.size() / c3d_block;
    parts.header.data_block = static_cast<uint16_t>(block);
    if (C3dParameter* start = parts.parameters.find("POINT", "DATA_START"))
      start->numbers = {static_cast<double>(block)};
    section = encode_section(parts.parameters, parts.processor, losses);
  }
  return encode_header(parts.header, parts.processor) + section + parts.data;
}

void put_u16(std::string& bytes, std::size_t at, unsigned value) {
  bytes.at(at) = static_cast<char>(value & 0xFFU);
  bytes.at(at + 1) = static_cast<char>(value >> 8U);
}

void put_real(std::string& bytes, std::size_t at, float value) {
  ASSERT_LE(at + 4, bytes.size());
  std::memcpy(bytes.data() + at, &value, 4);
}

void erase_parameter(C3dParameters& tree, const std::string& group, const std::string& name) {
  C3dGroup* owner = tree.group(group);
  ASSERT_NE(owner, nullptr);
  EXPECT_EQ(std::erase_if(owner->parameters, [&](const C3dParameter& p) { return p.name == name; }),
            1U);
}

}  // namespace kinemesh::test
