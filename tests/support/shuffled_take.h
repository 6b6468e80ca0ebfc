// A take as a system delivers it that knows no labels.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/marker_sequence.h"

namespace kinemesh::test {

struct ShuffledTake {
  MarkerSequence take;
  std::vector<std::vector<std::size_t>> order;  ///< [frame][i]: the marker whose point i is
};

/// All measured markers as points without label, in another order in every frame.
ShuffledTake without_labels(const MarkerSequence& take, uint32_t seed);

}  // namespace kinemesh::test
