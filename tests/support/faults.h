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

struct StrayTake {
  MarkerSequence take;
  std::vector<Stray> strays;  ///< with the owner where it is one
};

/// Stretches of 5 to 30 frames, each with gaps of 3 to 20 frames on either side, hold something
/// else: the samples of another marker, lost then, one of the six nearest (even ones), or a
/// reflection 12 to 60 mm beside the marker (odd ones). One a marker.
StrayTake with_strays(MarkerSequence take, std::size_t count, uint32_t seed);
/// The same gaps around stretches that are right.
MarkerSequence with_islands(MarkerSequence take, std::size_t count, uint32_t seed);

}  // namespace kinemesh::test
