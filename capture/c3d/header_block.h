// The first 512 bytes of a C3D file.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/c3d/finding.h"
#include "capture/c3d/layout.h"

namespace kinemesh {

inline constexpr std::size_t c3d_block = 512;

/// Decodes a header of at least 24 bytes; what a shorter block lacks stays 0. Events without a
/// usable time are left out with a finding.
C3dHeader decode_header(std::span<const std::byte> block, Processor processor,
                        std::vector<C3dFinding>& findings);

/// The 512 bytes of a header. Only the first 18 events fit; labels are cut to four bytes.
std::string encode_header(const C3dHeader& header, Processor processor);

}  // namespace kinemesh
