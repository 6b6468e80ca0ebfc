// What the analog channels of a C3D file are, and how their samples become physical values.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "capture/c3d/finding.h"
#include "capture/c3d/layout.h"
#include "capture/marker_sequence.h"

namespace kinemesh {

/// value = (sample − offset) × factor, per channel.
struct AnalogTable {
  std::vector<AnalogData::Channel> channels;
  std::vector<double> offsets;
  std::vector<double> factors;    ///< SCALE × GEN_SCALE
  bool unsigned_samples = false;  ///< integer samples are unsigned
};

/// `first_samples` are stored samples of the first frames (frame by frame, channel fastest, as
/// signed numbers); they decide whether negative offsets are unsigned ones where ANALOG:FORMAT
/// does not. May be empty.
AnalogTable decode_analog_table(const C3dParameters& parameters, const C3dLayout& layout,
                                std::span<const float> first_samples,
                                std::vector<C3dFinding>& findings);

/// Samples per second; notes a missing or disagreeing ANALOG:RATE.
double analog_rate(const C3dParameters& parameters, const C3dLayout& layout,
                   std::vector<C3dFinding>& findings);

}  // namespace kinemesh
