// Faults put into a take at known places, to measure what repair finds.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/marker_sequence.h"
#include "capture/repair.h"

namespace kinemesh::test {

struct SpikyTake {
  MarkerSequence take;
  std::vector<Spike> spikes;  ///< in the order put in
};

/// This share of the measured samples becomes spikes of one to three frames (of 35 ms at most), 3
/// to 50 mm long (uniform in the logarithm) in any direction; two of a marker are at least `apart`
/// frames from each other.
SpikyTake with_spikes(MarkerSequence take, double share, uint32_t seed, std::size_t apart = 2);

/// Spikes of `found` that are none of `truth`, by marker and frames that overlap.
std::size_t not_among(const std::vector<Spike>& found, const std::vector<Spike>& truth);

/// The samples of these markers go round in the frames [from, until): each gets those of the next.
void rotate_labels(MarkerSequence& take, const std::vector<std::size_t>& markers, std::size_t from,
                   std::size_t until);

}  // namespace kinemesh::test
