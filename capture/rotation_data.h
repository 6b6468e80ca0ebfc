// Editing of the rotations that a C3D file holds beside its points (group ROTATION).
#pragma once

#include <Eigen/Core>

#include "capture/gaps.h"
#include "capture/marker_sequence.h"

namespace kinemesh {

/// Those of these frames alone.
RotationData rotations_in(const RotationData& rotations, FrameRange frames);

/// `second` behind `first`, which has `frames` frames, with `pause` unmeasured ones in between, as
/// many frames as both takes have together. Nothing when they differ in number or rate and cannot
/// follow each other.
RotationData joined_rotations(const RotationData& first, std::size_t frames,
                              const RotationData& second, std::size_t pause);

/// The rotations of one frame in coordinates p' = turn · p + shift; `shift` in the unit of the
/// translations.
void move_rotations(RotationData& rotations, std::size_t frame, const Eigen::Matrix3d& turn,
                    const Eigen::Vector3d& shift);

/// The same rotations with translations in another unit of length.
void scale_rotations(RotationData& rotations, double factor);

}  // namespace kinemesh
