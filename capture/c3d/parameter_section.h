// Finds and parses the parameter section of a C3D file, damaged or not, and writes one.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "capture/c3d/byte_source.h"
#include "capture/c3d/finding.h"
#include "capture/c3d/layout.h"
#include "capture/c3d/parameters.h"

namespace kinemesh {

/// Where the section begins (its four bytes before the first record) and in which number format
/// it, and with it the whole file, is written.
struct C3dSectionStart {
  std::size_t begin = 0;
  Processor processor = Processor::intel;
};

/// The section that the header points to; failing that, any that can be found in the first 130 kB.
/// `leading` zero bytes precede the header, `block` is the header's 1-based pointer.
std::optional<C3dSectionStart> find_section(const ByteSource& source, std::size_t leading,
                                            std::size_t block, std::vector<C3dFinding>& findings);

struct C3dSection {
  C3dParameters parameters;
  std::vector<C3dParameterPlace> places;
  std::size_t end = 0;  ///< absolute byte behind the last record
};

/// Follows the chain of records from `start` to its end, at most to `limit` (absolute).
C3dSection parse_section(const ByteSource& source, const C3dSectionStart& start, std::size_t limit,
                         std::vector<C3dFinding>& findings);

/// The section as bytes, padded to whole blocks, and what the format could not hold of it (one
/// sentence each). The 8-bit block count saturates; readers follow the chain.
std::string encode_section(const C3dParameters& parameters, Processor processor,
                           std::vector<std::string>& losses);

}  // namespace kinemesh
