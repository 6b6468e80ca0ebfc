// What cannot be known of a marker that was hardly ever measured: its own samples do not show how
// it moves, so the band must cover what the markers around it do.
#pragma once

#include <vector>

#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// True for a marker that is measured in less than a quarter of the frames.
bool is_scarce(const Trajectories& take, std::size_t marker);

/// Raises `estimate.sd` of a scarce marker's gap to how far that one of its eight nearest
/// neighbours that moved most is from its mean place in the marker's measured frames (distance /
/// √3, mm), beyond the farthest any is in those. Head motion is taken out by a rigid fit. With
/// fewer than four other markers the standard deviation is 10 mm at least.
/// `rough`: the take with every gap filled provisionally.
void raise_sd_of_scarce(const Trajectories& take, const Trajectories& rough, const GapAt& gap,
                        Estimate& estimate);

}  // namespace kinemesh::fill
