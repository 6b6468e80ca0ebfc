#include "tests/support/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinemesh::test {

ClosestPoint::ClosestPoint(std::vector<Eigen::Vector3d> positions, std::vector<Triangle> faces,
                           double cell_mm)
    : positions_(std::move(positions)), faces_(std::move(faces)), cell_(cell_mm) {
  low_.fill(std::numeric_limits<int>::max());
  high_.fill(std::numeric_limits<int>::min());
  for (FaceIndex f = 0; f < faces_.size(); ++f) {
    Eigen::Vector3d low = positions_[faces_[f][0]], high = low;
    for (const VertexIndex v : faces_[f]) {
      low = low.cwiseMin(positions_[v]);
      high = high.cwiseMax(positions_[v]);
    }
    const Cell from = cell_of(low), to = cell_of(high);
    for (int k = 0; k < 3; ++k) {
      low_[k] = std::min(low_[k], from[k]);
      high_[k] = std::max(high_[k], to[k]);
    }
    for (int x = from[0]; x <= to[0]; ++x) {
      for (int y = from[1]; y <= to[1]; ++y) {
        for (int z = from[2]; z <= to[2]; ++z) grid_[key_of({x, y, z})].push_back(f);
      }
    }
  }
}

ClosestPoint::Cell ClosestPoint::cell_of(const Eigen::Vector3d& p) const {
  return {static_cast<int>(std::floor(p.x() / cell_)), static_cast<int>(std::floor(p.y() / cell_)),
          static_cast<int>(std::floor(p.z() / cell_))};
}

uint64_t ClosestPoint::key_of(const Cell& c) {
  const auto part = [](int x) { return static_cast<uint64_t>(x + (1 << 20)) & 0x1FFFFF; };
  return part(c[0]) << 42 | part(c[1]) << 21 | part(c[2]);
}

ClosestPoint::Hit ClosestPoint::closest(const Eigen::Vector3d& p) const {
  Hit best;
  best.distance = std::numeric_limits<double>::infinity();
  const Cell centre = cell_of(p);
  int furthest = 0;
  for (int k = 0; k < 3; ++k) {
    furthest = std::max({furthest, std::abs(centre[k] - low_[k]), std::abs(centre[k] - high_[k])});
  }
  for (int ring = 0; ring <= furthest && best.distance > (ring - 1) * cell_; ++ring) {
    for (int x = -ring; x <= ring; ++x) {
      for (int y = -ring; y <= ring; ++y) {
        const bool shell = std::abs(x) == ring || std::abs(y) == ring;
        for (int z = -ring; z <= ring; z += shell || ring == 0 ? 1 : 2 * ring) {
          const auto found = grid_.find(key_of({centre[0] + x, centre[1] + y, centre[2] + z}));
          if (found == grid_.end()) continue;
          for (const FaceIndex f : found->second) {
            const Triangle& t = faces_[f];
            const Eigen::Vector3d w =
                closest_weights(p, positions_[t[0]], positions_[t[1]], positions_[t[2]]);
            const double distance =
                (w[0] * positions_[t[0]] + w[1] * positions_[t[1]] + w[2] * positions_[t[2]] - p)
                    .norm();
            if (distance < best.distance) best = {distance, f, w};
          }
        }
      }
    }
  }
  return best;
}

}  // namespace kinemesh::test
