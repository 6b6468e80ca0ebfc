// A take's time: cut, joined, sampled anew, with everything that belongs to it.
#pragma once

#include <string>
#include <vector>

#include "capture/gaps.h"
#include "capture/marker_sequence.h"
#include "config/run_context.h"

namespace kinemesh {

/// A take of `frames` frames and these markers, all invalid, with the description of `take`: rate,
/// first frame, events, origin, parameters; without unlabelled points and analog values.
MarkerSequence empty_like(const MarkerSequence& take, std::size_t frames,
                          std::vector<Marker> markers);
/// One sample with all that belongs to it.
void copy_sample(const MarkerSequence& from, std::size_t from_sample, MarkerSequence& to,
                 std::size_t to_sample);

/// The frames alone, with their analog samples, rotations and unlabelled points. They are numbered
/// from 1 again; events keep their instants, those outside are dropped.
MarkerSequence crop_frames(const MarkerSequence& take, FrameRange frames);

/// `second` after `first`, with `pause` frames without data in between. Markers are matched by
/// subject and label; where one take lacks a marker it is invalid. Analog data are joined when both
/// have the same channels, otherwise those of `first` are kept, followed by zeros, with a note;
/// rotations when they are as many at the same rate, otherwise they are left out, with a note.
/// Throws UsageError when the rates differ.
MarkerSequence join_takes(const MarkerSequence& first, const MarkerSequence& second,
                          std::size_t pause, std::vector<std::string>* notes = nullptr);

/// Every run of valid samples as a natural cubic spline, read at the new rate; a new sample is
/// valid where the samples around it are. Unlabelled points are those of the nearest frame. Analog
/// data keep their rate when it is a multiple of the new one, otherwise they are interpolated
/// linearly. Rotations are left out. Throws UsageError when the take has no rate.
MarkerSequence resample_take(const MarkerSequence& take, double rate_hz,
                             const RunContext& ctx = {});

}  // namespace kinemesh
