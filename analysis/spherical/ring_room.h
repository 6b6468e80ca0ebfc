// Room for a vertex that comes back among its neighbours on the sphere. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis/spherical/kernel.h"
#include "analysis/spherical/ring_mesh.h"

namespace kinemesh::spherical {

/// Whether v sees the whole ring counter-clockwise, in exact arithmetic.
bool star_is_valid(VertexIndex v, std::span<const VertexIndex> ring,
                   std::span<const Eigen::Vector3d> points);

class RingRoom {
 public:
  /// Keeps references. Vertices with `held` set never move; empty: none is held.
  RingRoom(const RingMesh& mesh, std::vector<Eigen::Vector3d>& points,
           std::span<const uint8_t> held = {});

  /// Vertices within `depth` edges of those of `ring`, those first.
  std::vector<VertexIndex> surroundings(std::span<const VertexIndex> ring, int depth);
  /// The centre of the ring's kernel. Where that is too narrow to be trusted in floating point, the
  /// vertices around it are moved to the centres of theirs first, ever wider; `moved` are those.
  KernelPoint centre_of(std::span<const VertexIndex> ring);
  const std::vector<VertexIndex>& moved() const { return moved_; }

 private:
  void recentre(VertexIndex v);

  const RingMesh& mesh_;
  std::vector<Eigen::Vector3d>& points_;
  std::span<const uint8_t> held_;
  std::vector<VertexIndex> moved_;
  std::vector<uint32_t> marks_;  // of surroundings(): the last search that met a vertex
  uint32_t mark_ = 0;
};

/// Neighbours above which a vertex only moves with whole levels.
inline constexpr std::size_t hub = 40;

}  // namespace kinemesh::spherical
