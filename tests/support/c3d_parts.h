// C3D files taken apart and put together wrongly on purpose.
#pragma once

#include <cstddef>
#include <string>

#include "capture/c3d/layout.h"
#include "capture/c3d/parameters.h"
#include "capture/marker_sequence.h"

namespace kinemesh::test {

struct C3dParts {
  Processor processor = Processor::intel;
  C3dHeader header;
  C3dParameters parameters;
  std::string data;
};

/// Parts of a file that the writer made.
C3dParts take_apart(const std::string& bytes);

/// Header, parameters, data. With `place_data`, header and POINT:DATA_START point to the data;
/// otherwise they keep what they say.
std::string put_together(C3dParts parts, bool place_data = true);

/// Overwrites 16 bits, little-endian.
void put_u16(std::string& bytes, std::size_t at, unsigned value);
/// Overwrites an IEEE float, little-endian.
void put_real(std::string& bytes, std::size_t at, float value);

/// Removes a parameter; the test fails if there is none.
void erase_parameter(C3dParameters& tree, const std::string& group, const std::string& name);

}  // namespace kinemesh::test
