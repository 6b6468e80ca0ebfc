// Takes made for tests of the C3D reader and writer.
#pragma once

#include <cstddef>
#include <string>

#include "capture/c3d/reader.h"
#include "capture/marker_sequence.h"

namespace kinemesh::test {

/// Markers M1, M2… on smooth paths in multiples of 1/16 mm (which every storage with a scale of
/// 1/16 holds exactly), every seventh sample invalid, residuals and masks varying, at 100 Hz.
MarkerSequence make_take(std::size_t frames, std::size_t markers);

/// Adds `channels` analog channels of `samples` per frame with whole-numbered values.
void add_analog(MarkerSequence& take, std::size_t channels, std::size_t samples);

/// Reads back what was encoded.
C3dReadResult read_encoded(const std::string& bytes, const C3dReadOptions& options = {});

/// Byte of a parameter's first value in an encoded file.
std::size_t place_of(const std::string& bytes, const std::string& group, const std::string& name);

/// Fails the running test where two takes differ in any decoded value (positions of invalid
/// samples aside, unless both are finite and the storage is the same).
void expect_same_take(const MarkerSequence& a, const MarkerSequence& b, float position_tolerance,
                      float residual_tolerance, float analog_tolerance);

bool has_finding(const C3dReadResult& r, std::string_view code);

}  // namespace kinemesh::test
