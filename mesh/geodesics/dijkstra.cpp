#include "mesh/geodesics/dijkstra.h"

#include <queue>

namespace kinemesh::geodesics {
namespace {

struct Entry {
  double distance;
  VertexIndex vertex;
  bool operator>(const Entry& o) const {
    return distance != o.distance ? distance > o.distance : vertex > o.vertex;
  }
};
using Queue = std::priority_queue<Entry, std::vector<Entry>, std::greater<>>;

/// Neighbours of every vertex with the lengths of the edges between, in rows.
struct EdgeGraph {
  explicit EdgeGraph(const UnfoldedMesh& mesh) : offsets(mesh.vertex_count() + 1, 0) {
    const auto halfedges = static_cast<HalfedgeIndex>(3 * mesh.face_count());
    const auto each = [&](auto&& visit) {
      for (HalfedgeIndex h = 0; h < halfedges; ++h) {
        const Frame& frame = mesh.frame(h);
        visit(frame.ends[0], frame.ends[1], frame.length);
        if (mesh.twin(h) == invalid_index) visit(frame.ends[1], frame.ends[0], frame.length);
      }
    };
    each([&](VertexIndex from, VertexIndex, double) { ++offsets[from + 1]; });
    for (std::size_t v = 0; v + 1 < offsets.size(); ++v) offsets[v + 1] += offsets[v];
    ends.resize(offsets.back());
    lengths.resize(offsets.back());
    std::vector<std::size_t> next(offsets.begin(), offsets.end() - 1);
    each([&](VertexIndex from, VertexIndex to, double length) {
      ends[next[from]] = to;
      lengths[next[from]++] = length;
    });
  }
  std::vector<std::size_t> offsets;
  std::vector<VertexIndex> ends;
  std::vector<double> lengths;
};

}  // namespace

EdgePaths dijkstra(const UnfoldedMesh& mesh, std::span<const SurfacePoint> sources, double radius,
                   const RunContext& ctx) {
  EdgePaths result{std::vector<double>(mesh.vertex_count(), unreachable),
                   std::vector<GeodesicArrival>(mesh.vertex_count())};
  const EdgeGraph graph(mesh);
  Queue queue;
  const auto reach = [&](VertexIndex v, double distance, uint32_t origin) {
    if (!(distance < result.distances[v]) || distance > radius) return;
    result.distances[v] = distance;
    result.arrivals[v] = {0.0, 0.0, invalid_index, origin};
    queue.push({distance, v});
  };
  for (uint32_t s = 0; s < sources.size(); ++s) {
    for (HalfedgeIndex h = 3 * sources[s].face; h < 3 * sources[s].face + 3; ++h) {
      reach(mesh.frame(h).ends[0], mesh.in_frame(h, sources[s].weights).norm(),
            static_cast<uint32_t>(mesh.vertex_count() + s));
    }
  }
  for (std::size_t popped = 0; !queue.empty(); ++popped) {
    if (popped % 4096 == 0) ctx.check_cancelled();
    const auto [distance, v] = queue.top();
    queue.pop();
    if (distance > result.distances[v]) continue;
    for (std::size_t e = graph.offsets[v]; e < graph.offsets[v + 1]; ++e) {
      reach(graph.ends[e], distance + graph.lengths[e], v);
    }
  }
  return result;
}

}  // namespace kinemesh::geodesics
