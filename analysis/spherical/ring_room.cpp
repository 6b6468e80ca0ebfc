#include "analysis/spherical/ring_room.h"

#include "analysis/spherical/orientation.h"

namespace kinemesh::spherical {

namespace {

constexpr double narrow = 0.02;    // roominess below which the ring is re-centred first
constexpr double hopeless = 1e-5;  // roominess below which that goes on, ever wider
constexpr int rounds = 12;         // of re-centring, at most

}  // namespace

bool star_is_valid(VertexIndex v, std::span<const VertexIndex> ring,
                   std::span<const Eigen::Vector3d> points) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    if (orientation(points[v], points[ring[i]], points[ring[(i + 1) % ring.size()]]) <= 0)
      return false;
  }
  return true;
}

RingRoom::RingRoom(const RingMesh& mesh, std::vector<Eigen::Vector3d>& points,
                   std::span<const uint8_t> held)
    : mesh_(mesh), points_(points), held_(held), marks_(points.size(), 0) {}

std::vector<VertexIndex> RingRoom::surroundings(std::span<const VertexIndex> ring, int depth) {
  std::vector<VertexIndex> found(ring.begin(), ring.end());
  ++mark_;
  for (const VertexIndex v : found) marks_[v] = mark_;
  std::size_t begin = 0;
  for (int k = 0; k < depth; ++k) {
    for (const std::size_t end = found.size(); begin < end; ++begin) {
      for (const VertexIndex r : mesh_.ring(found[begin])) {
        if (marks_[r] == mark_) continue;
        marks_[r] = mark_;
        found.push_back(r);
      }
    }
  }
  return found;
}

/// Moves a vertex to the centre of its own kernel, or leaves it.
void RingRoom::recentre(VertexIndex v) {
  if (mesh_.ring(v).size() > hub || (!held_.empty() && held_[v] != 0)) return;
  const KernelPoint centre = kernel_centre(mesh_.ring(v), points_);
  if (!(centre.distance > 0.0)) return;
  const Eigen::Vector3d before = points_[v];
  points_[v] = centre.point;
  if (star_is_valid(v, mesh_.ring(v), points_)) {
    moved_.push_back(v);
  } else {
    points_[v] = before;
  }
}

KernelPoint RingRoom::centre_of(std::span<const VertexIndex> ring) {
  moved_.clear();
  KernelPoint centre = kernel_centre(ring, points_);
  for (int round = 0; round < rounds && centre.roominess < (round < 3 ? narrow : hopeless);
       ++round) {
    for (const VertexIndex r : surroundings(ring, round / 3)) recentre(r);
    centre = kernel_centre(ring, points_);
  }
  return centre;
}

}  // namespace kinemesh::spherical
