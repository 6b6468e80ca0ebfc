#include "tests/support/shuffled_take.h"

#include <algorithm>
#include <random>

namespace kinemesh::test {

ShuffledTake without_labels(const MarkerSequence& take, uint32_t seed) {
  ShuffledTake out;
  out.take = MarkerSequence::invalid(take.frame_count(), {}, take.rate_hz);
  out.take.unlabelled.offsets.push_back(0);
  std::mt19937 random(seed);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    std::vector<std::size_t> seen;
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      if (take.valid(f, m) && take.markers()[m].kind == MarkerKind::marker) seen.push_back(m);
    }
    std::ranges::shuffle(seen, random);
    for (const std::size_t m : seen) {
      out.take.unlabelled.positions.emplace_back(take.position(f, m));
      out.take.unlabelled.residuals.push_back(0.1F);
      out.take.unlabelled.camera_masks.push_back(0);
    }
    out.take.unlabelled.offsets.push_back(out.take.unlabelled.positions.size());
    out.order.push_back(std::move(seen));
  }
  return out;
}

}  // namespace kinemesh::test
