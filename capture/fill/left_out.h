// How far a method that knows no uncertainty of its own is off: measured on stretches of the same
// marker that are known and left out.
#pragma once

#include <functional>

#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// A method; it must not read the marker's samples inside the gap.
using Method = std::function<std::optional<Estimate>(const GapAt&)>;

/// Sets `estimate.sd` from the method's errors on up to eight stretches of the gap's length, spread
/// over the measured part of the marker. Within a gap the standard deviation follows that of a
/// random walk tied at both ends (for gaps at the ends of the take: at one).
void set_sd_from_left_out(const Trajectories& take, const GapAt& gap, const Method& method,
                          Estimate& estimate);

}  // namespace kinemesh::fill
