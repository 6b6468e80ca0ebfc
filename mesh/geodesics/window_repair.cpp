// What the pencils of straight paths missed by rounding, found by the edges: no vertex is further
// away than its neighbour and the edge between them.
#include "mesh/geodesics/window_propagation.h"

namespace kinemesh::geodesics {
namespace {

/// Rounding of two distances and an edge.
constexpr double clearly_further = 1.0 + 1e-12;

}  // namespace

bool WindowPropagation::reach_missed(VertexIndex from, VertexIndex to, double length) {
  const double distance = distances_[from] + length;
  if (!(distances_[to] > distance * clearly_further) || distance > radius_) return false;
  reach(to, distance, -1.0, {0.0, 0.0, invalid_index, from});
  return true;
}

bool WindowPropagation::reach_missed_around(VertexIndex v) {
  bool any = false;
  const auto look = [&](HalfedgeIndex corner) {
    const Frame& out = mesh_.frame(corner);
    any |= reach_missed(v, out.ends[1], out.length);
    any |= reach_missed(v, out.apex, out.sides[0].length);
  };
  const HalfedgeIndex first = mesh_.outgoing(v);
  if (first == invalid_index) return false;
  if (mesh_.kind(v) == VertexKind::irregular) {
    for (const HalfedgeIndex h : mesh_.corners_of_irregular(v)) look(h);
    return any;
  }
  HalfedgeIndex h = first;
  do {
    look(h);
    h = mesh_.twin(Topology::previous(h));
  } while (h != invalid_index && h != first);
  return any;
}

/// Reaches missed vertices along an edge and lets them bend paths all around. False when there are
/// none.
bool WindowPropagation::reach_missed_vertices() {
  bool any = false;
  if (radius_ < infinity) {  // at the cost of what lies inside
    const std::vector<VertexIndex> reached = reached_;
    for (const VertexIndex v : reached) any |= reach_missed_around(v);
    return any;
  }
  for (const Edge& edge : mesh_.edges()) {
    any |= reach_missed(edge.ends[0], edge.ends[1], edge.length);
    any |= reach_missed(edge.ends[1], edge.ends[0], edge.length);
  }
  return any;
}

}  // namespace kinemesh::geodesics
