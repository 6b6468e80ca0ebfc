#include "analysis/spherical/ring_mesh.h"

#include <algorithm>
#include <limits>
#include <queue>

namespace kinemesh::spherical {

namespace {

constexpr std::size_t largest_ring = 10;  // of a vertex that is removed

std::size_t index_in(const std::vector<VertexIndex>& ring, VertexIndex v) {
  return static_cast<std::size_t>(std::ranges::find(ring, v) - ring.begin());
}

/// Collapses in the order of their cost, the largest new edge.
class Simplifier {
 public:
  Simplifier(RingMesh& mesh, std::span<const Eigen::Vector3d> positions,
             std::span<const uint8_t> keep)
      : mesh_(mesh), positions_(positions), keep_(keep), stamps_(positions.size(), 0) {
    for (const VertexIndex v : mesh.alive()) push(v);
  }

  void run(std::size_t least, const RunContext& ctx) {
    std::size_t done = 0;
    while (mesh_.alive_count() > least && !queue_.empty()) {
      if (++done % 1024 == 0) ctx.check_cancelled();
      const Candidate best = queue_.top();
      queue_.pop();
      if (best.stamp != stamps_[best.vertex]) continue;
      if (!mesh_.can_collapse(best.vertex, best.onto)) {
        push(best.vertex);
        continue;
      }
      ++stamps_[best.vertex];
      mesh_.collapse(best.vertex, best.onto);
      for (const VertexIndex r : mesh_.next_ring()) push(r);
    }
  }

 private:
  struct Candidate {
    double cost;
    VertexIndex vertex, onto;
    uint32_t stamp;
    bool operator<(const Candidate& other) const {
      return cost != other.cost ? cost > other.cost : vertex > other.vertex;
    }
  };

  double cost_of(const std::vector<VertexIndex>& ring, VertexIndex w) const {
    double longest = 0.0;
    for (const VertexIndex r : ring) {
      longest = std::max(longest, (positions_[r] - positions_[w]).squaredNorm());
    }
    const double valence = static_cast<double>(mesh_.ring(w).size() + ring.size()) - 4.0;
    const double excess = std::max(0.0, valence - 7.0);
    return longest * (1.0 + 0.2 * excess * excess);
  }

  void push(VertexIndex v) {
    ++stamps_[v];
    const std::vector<VertexIndex>& ring = mesh_.ring(v);
    if ((!keep_.empty() && keep_[v] != 0) || ring.size() > largest_ring) return;
    Candidate best{std::numeric_limits<double>::infinity(), v, invalid_index, stamps_[v]};
    for (const VertexIndex w : ring) {
      const double cost = cost_of(ring, w);
      if (cost < best.cost && mesh_.can_collapse(v, w)) {
        best.cost = cost;
        best.onto = w;
      }
    }
    if (best.onto != invalid_index) queue_.push(best);
  }

  RingMesh& mesh_;
  std::span<const Eigen::Vector3d> positions_;
  std::span<const uint8_t> keep_;
  std::vector<uint32_t> stamps_;
  std::priority_queue<Candidate> queue_;
};

}  // namespace

RingMesh::RingMesh(const Topology& topology)
    : rings_(topology.vertex_count()), place_(topology.vertex_count()) {
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    const FaceIndex first_face = topology.faces_of(v)[0];
    HalfedgeIndex first = 3 * first_face;
    while (topology.from(first) != v) ++first;
    HalfedgeIndex h = first;
    do {
      rings_[v].push_back(topology.to(h));
      h = topology.twin(Topology::previous(h));
    } while (h != first);
    place_[v] = v;
    alive_.push_back(v);
  }
}

bool RingMesh::can_collapse(VertexIndex v, VertexIndex w) const {
  if (alive_.size() <= 4) return false;
  std::size_t common = 0;
  for (const VertexIndex r : rings_[v]) {
    if (r != w && std::ranges::find(rings_[w], r) != rings_[w].end()) ++common;
  }
  return common == 2;
}

void RingMesh::collapse(VertexIndex v, VertexIndex w) {
  std::vector<VertexIndex> ring = std::move(rings_[v]);
  rings_[v].clear();
  std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(index_in(ring, w)),
              ring.end());
  const std::size_t n = ring.size();  // ring[0] is w; ring[1] and ring[n - 1] see both
  for (const std::size_t i : {std::size_t{1}, n - 1}) {
    std::vector<VertexIndex>& other = rings_[ring[i]];
    other.erase(other.begin() + static_cast<std::ptrdiff_t>(index_in(other, v)));
  }
  for (std::size_t i = 2; i + 1 < n; ++i) {
    std::vector<VertexIndex>& other = rings_[ring[i]];
    other[index_in(other, v)] = w;
  }
  // Around w, counter-clockwise, come …, ring[1], v, ring[n - 1], …
  std::vector<VertexIndex>& onto = rings_[w];
  const std::size_t at = index_in(onto, v);
  onto.erase(onto.begin() + static_cast<std::ptrdiff_t>(at));
  onto.insert(onto.begin() + static_cast<std::ptrdiff_t>(at), ring.begin() + 2, ring.end() - 1);
  alive_[place_[v]] = alive_.back();
  place_[alive_.back()] = place_[v];
  alive_.pop_back();
  removals_.push_back({v, w, std::move(ring)});
}

std::span<const VertexIndex> RingMesh::next_ring() const { return removals_.back().ring; }

void RingMesh::restore() {
  Removal last = std::move(removals_.back());
  removals_.pop_back();
  const VertexIndex v = last.vertex, w = last.onto;
  const std::vector<VertexIndex>& ring = last.ring;
  const std::size_t n = ring.size();
  std::vector<VertexIndex>& onto = rings_[w];
  std::rotate(onto.begin(), onto.begin() + static_cast<std::ptrdiff_t>(index_in(onto, ring[1])),
              onto.end());
  onto.erase(onto.begin() + 1, onto.begin() + static_cast<std::ptrdiff_t>(n - 2));
  onto.insert(onto.begin() + 1, v);
  for (std::size_t i = 2; i + 1 < n; ++i) {
    std::vector<VertexIndex>& other = rings_[ring[i]];
    other[index_in(other, w)] = v;
  }
  // v comes back beside w: before it around ring[1], after it around ring[n - 1].
  std::vector<VertexIndex>& first = rings_[ring[1]];
  std::vector<VertexIndex>& last_ring = rings_[ring[n - 1]];
  first.insert(first.begin() + static_cast<std::ptrdiff_t>(index_in(first, w)), v);
  last_ring.insert(last_ring.begin() + static_cast<std::ptrdiff_t>(index_in(last_ring, w)) + 1, v);
  place_[v] = static_cast<uint32_t>(alive_.size());
  alive_.push_back(v);
  rings_[v] = std::move(last.ring);
}

void simplify(RingMesh& mesh, std::span<const Eigen::Vector3d> positions, std::size_t least,
              std::span<const uint8_t> keep, const RunContext& ctx) {
  Simplifier(mesh, positions, keep).run(least, ctx);
}

}  // namespace kinemesh::spherical
