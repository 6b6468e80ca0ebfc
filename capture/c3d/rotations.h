// The data of group ROTATION: for each frame RATIO samples of USED rotations, each a 4 × 4 matrix,
// column by column, and its reliability, as 32-bit floats in integer files too. They lie in a
// block of their own, at ROTATION:DATA_START (c3d.org, "The C3D file format", ROTATION group).
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "capture/c3d/layout_resolver.h"
#include "capture/marker_sequence.h"

namespace kinemesh {

constexpr uint64_t rotation_floats = 17;
constexpr uint64_t rotation_bytes = rotation_floats * 4;

/// Finds where the rotations lie, if there are any: `layout.rotations…`. Needs layout.rate_hz.
void find_rotations(const C3dHead& head, C3dLayout& layout);

/// Settles how many rotations can be read once `layout` is complete otherwise, and says so (C3D315,
/// C3D319). Rotations that lie outside the file or inside the points are given up.
void settle_rotations(C3dLayout& layout, std::vector<C3dFinding>& findings);

/// Reads them into take.rotations; those that the file lacks have reliability -1.
void read_rotations(const ByteSource& source, const C3dLayout& layout, MarkerSequence& take);

/// Hands all rotations to `sink`, in the number format `p`, the last block filled with zeros.
void write_rotations(const RotationData& rotations, Processor p,
                     const std::function<void(const void*, std::size_t)>& sink);

}  // namespace kinemesh
