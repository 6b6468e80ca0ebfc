// Decides what a C3D file's header and parameters, which often disagree, say about its data.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "capture/c3d/byte_source.h"
#include "capture/c3d/finding.h"
#include "capture/c3d/layout.h"
#include "capture/c3d/parameters.h"

namespace kinemesh {

/// What is known before the layout is decided.
struct C3dHead {
  const ByteSource& source;
  const C3dHeader& header;
  const C3dParameters& parameters;
  std::size_t leading = 0;
  std::size_t section_begin = 0;
  std::size_t section_end = 0;  ///< 0 without a parameter section
  Processor processor = Processor::intel;
  double unstated_rate_hz = 0.0;  ///< of a file that gives none; 0: 1 Hz, and a finding
};

/// Where sources disagree, the combination that fits the size of the data section wins; among
/// several that fit, parameters come before the header, but for the place of the data, which the
/// header knows best. Every disagreement is a finding. Frames are those complete in the file.
C3dLayout resolve_layout(const C3dHead& head, std::vector<C3dFinding>& findings);

}  // namespace kinemesh
