// Small neighbourhoods on a surface that hardly depend on how it is triangulated.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "config/run_context.h"
#include "mesh/surface_measures.h"
#include "mesh/topology.h"

namespace kinemesh {

/// Lists of vertices, one per vertex of a mesh, in one piece.
struct VertexLists {
  std::vector<uint64_t> offsets;  ///< vertices + 1
  std::vector<VertexIndex> items;
  std::span<const VertexIndex> of(std::size_t v) const {
    return {items.data() + offsets[v], items.data() + offsets[v + 1]};
  }
};

/// For each vertex those within `radius_mm` of it, itself first, then by rising path length: the
/// straight distance is at most the radius, and a path along edges within the radius' sphere is at
/// most 1.3 times as long (so that the other lip does not belong to it). The neighbours over an
/// edge always belong.
VertexLists surface_balls(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                          double radius_mm, const RunContext& ctx = {});

/// The same, but of large balls only a sample that is fixed for each vertex: about 200 to a ball,
/// so that memory and time grow with the vertices and not with their square.
VertexLists sampled_balls(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                          double radius_mm, const RunContext& ctx);

}  // namespace kinemesh
