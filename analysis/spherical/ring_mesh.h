// A closed triangle mesh as the ring of each vertex, taken apart by edge collapses and put together
// again in reverse order. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "config/run_context.h"
#include "mesh/topology.h"

namespace kinemesh::spherical {

class RingMesh {
 public:
  /// The topology must be closed, manifold and connected.
  explicit RingMesh(const Topology& topology);

  /// Neighbours counter-clockwise: the triangles around v are (v, ring[i], ring[i + 1]).
  const std::vector<VertexIndex>& ring(VertexIndex v) const { return rings_[v]; }
  std::size_t alive_count() const { return alive_.size(); }
  /// Vertices of the present mesh, in no order that means anything.
  const std::vector<VertexIndex>& alive() const { return alive_; }
  std::size_t removed_count() const { return removals_.size(); }

  /// Whether removing v by moving it onto its neighbour w leaves a closed manifold mesh.
  bool can_collapse(VertexIndex v, VertexIndex w) const;
  void collapse(VertexIndex v, VertexIndex w);
  /// The vertex that comes back next; its ring as it will be.
  VertexIndex next() const { return removals_.back().vertex; }
  /// The vertex onto which it was moved.
  VertexIndex next_onto() const { return removals_.back().onto; }
  std::span<const VertexIndex> next_ring() const;
  /// Undoes the last collapse.
  void restore();

 private:
  struct Removal {
    VertexIndex vertex, onto;
    std::vector<VertexIndex> ring;
  };
  std::vector<std::vector<VertexIndex>> rings_;
  std::vector<VertexIndex> alive_;
  std::vector<uint32_t> place_;  // of a vertex in alive_
  std::vector<Removal> removals_;
};

/// Collapses until `least` vertices are left, short edges first, so that what is left stays
/// evenly spread; vertices with `keep` set are never removed (then more may be left).
void simplify(RingMesh& mesh, std::span<const Eigen::Vector3d> positions, std::size_t least,
              std::span<const uint8_t> keep, const RunContext& ctx);

}  // namespace kinemesh::spherical
