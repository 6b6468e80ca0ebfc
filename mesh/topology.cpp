#include "mesh/topology.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <tuple>

#include "config/error.h"

namespace kinemesh {
namespace {

/// Offsets of a compressed row layout from the number of items in each row.
std::vector<uint32_t> offsets_from_counts(const std::vector<uint32_t>& counts) {
  std::vector<uint32_t> offsets(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), offsets.begin() + 1);
  return offsets;
}

void check_faces(std::size_t vertex_count, const std::vector<Triangle>& faces) {
  if (vertex_count >= invalid_index || faces.size() >= invalid_index / 3) {
    throw InputError({.what = "the mesh has more elements than 32-bit indices can name"});
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto& [a, b, c] = faces[f];
    const std::string place = "face " + std::to_string(f) + " (0-based)";
    const VertexIndex largest = std::max({a, b, c});
    if (largest >= vertex_count) {
      throw InputError({.what = "it refers to vertex " + std::to_string(largest) +
                                ", but there are only " + std::to_string(vertex_count),
                        .place = place});
    }
    if (a == b || b == c || c == a) {
      throw InputError({.what = "it uses the same vertex twice", .place = place});
    }
  }
}

}  // namespace

Topology::Topology(std::size_t vertex_count, std::vector<Triangle> faces)
    : vertex_count_(vertex_count), faces_(std::move(faces)) {
  check_faces(vertex_count_, faces_);
  pair_halfedges();
  build_rings();
  manifold_ = manifold_ && vertices_have_one_fan();
  trace_boundaries();
  count_components();
}

void Topology::pair_halfedges() {
  struct Key {
    VertexIndex high;
    HalfedgeIndex halfedge;
    bool operator<(const Key& o) const {
      return std::tie(high, halfedge) < std::tie(o.high, o.halfedge);
    }
  };
  // Counted into a row for the smaller end of the edge; few are left to sort in each.
  const auto halfedge_count = static_cast<HalfedgeIndex>(3 * faces_.size());
  std::vector<uint32_t> counts(vertex_count_, 0);
  for (HalfedgeIndex h = 0; h < halfedge_count; ++h) ++counts[std::min(from(h), to(h))];
  const std::vector<uint32_t> offsets = offsets_from_counts(counts);
  std::vector<uint32_t> cursor(offsets.begin(), offsets.end() - 1);
  std::vector<Key> keys(halfedge_count);
  for (HalfedgeIndex h = 0; h < halfedge_count; ++h) {
    keys[cursor[std::min(from(h), to(h))]++] = {std::max(from(h), to(h)), h};
  }
  twins_.assign(halfedge_count, invalid_index);
  std::size_t paired = 0;
  for (std::size_t low = 0; low < vertex_count_; ++low) {
    std::sort(keys.begin() + offsets[low], keys.begin() + offsets[low + 1]);
    for (std::size_t i = offsets[low], end = i; i < offsets[low + 1]; i = end) {
      while (end < offsets[low + 1] && keys[end].high == keys[i].high) ++end;
      ++distinct_edges_;
      const HalfedgeIndex first = keys[i].halfedge;
      if (end - i == 2 && from(first) == to(keys[i + 1].halfedge)) {
        twins_[first] = keys[i + 1].halfedge;
        twins_[keys[i + 1].halfedge] = first;
        paired += 2;
      } else if (end - i >= 2) {
        manifold_ = false;
      }
    }
  }
  edges_.reserve(halfedge_count - paired / 2);
  for (HalfedgeIndex h = 0; h < halfedge_count; ++h) {
    if (twins_[h] == invalid_index || h < twins_[h])
      edges_.push_back({{from(h), to(h)}, h, twins_[h]});
  }
}

void Topology::build_rings() {
  std::vector<uint32_t> counts(vertex_count_, 0);
  for (const Triangle& face : faces_) {
    for (const VertexIndex v : face) ++counts[v];
  }
  isolated_count_ = static_cast<std::size_t>(std::count(counts.begin(), counts.end(), 0U));
  face_offsets_ = offsets_from_counts(counts);
  face_list_.resize(face_offsets_.back());
  std::vector<uint32_t> cursor(face_offsets_.begin(), face_offsets_.end() - 1);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (const VertexIndex v : faces_[f]) face_list_[cursor[v]++] = static_cast<FaceIndex>(f);
  }

  neighbour_offsets_.assign(vertex_count_ + 1, 0);
  neighbour_list_.reserve(2 * edges_.size());
  std::vector<VertexIndex> ring;
  for (VertexIndex v = 0; v < vertex_count_; ++v) {
    ring.clear();
    for (const FaceIndex f : faces_of(v)) {
      for (const VertexIndex w : faces_[f]) {
        if (w != v) ring.push_back(w);
      }
    }
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    neighbour_list_.insert(neighbour_list_.end(), ring.begin(), ring.end());
    neighbour_offsets_[v + 1] = static_cast<uint32_t>(neighbour_list_.size());
  }
}

bool Topology::vertices_have_one_fan() const {
  for (VertexIndex v = 0; v < vertex_count_; ++v) {
    const auto around = faces_of(v);
    if (around.empty()) continue;
    // Walk the fan from its first face both ways; a second fan leaves faces unvisited.
    const auto& face = faces_[around[0]];
    const auto corner =
        static_cast<uint32_t>(std::find(face.begin(), face.end(), v) - face.begin());
    const HalfedgeIndex start = 3 * around[0] + corner;
    std::size_t visited = 1;
    HalfedgeIndex h = twins_[previous(start)];
    while (h != invalid_index && h != start && visited <= around.size()) {
      ++visited;
      h = twins_[previous(h)];
    }
    if (h == invalid_index) {
      for (h = twins_[start]; h != invalid_index && visited <= around.size(); h = twins_[next(h)]) {
        ++visited;
      }
    }
    if (visited != around.size()) return false;
  }
  return true;
}

void Topology::trace_boundaries() {
  boundary_vertex_.assign(vertex_count_, false);
  std::vector<bool> traced(twins_.size(), false);
  for (HalfedgeIndex start = 0; start < twins_.size(); ++start) {
    if (twins_[start] != invalid_index) continue;
    boundary_vertex_[from(start)] = true;
    boundary_vertex_[to(start)] = true;
    if (traced[start]) continue;
    std::vector<VertexIndex> loop;
    HalfedgeIndex h = start;
    while (!traced[h]) {
      traced[h] = true;
      loop.push_back(from(h));
      // The next boundary halfedge bounds the same fan at to(h): turn about it through the faces.
      HalfedgeIndex turn = next(h);
      for (std::size_t guard = 0; twins_[turn] != invalid_index && guard < twins_.size(); ++guard) {
        turn = next(twins_[turn]);
      }
      h = turn;
    }
    loops_.push_back(std::move(loop));
  }
}

void Topology::count_components() {
  std::vector<FaceIndex> parent(faces_.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](FaceIndex f) {
    while (parent[f] != f) f = parent[f] = parent[parent[f]];
    return f;
  };
  component_count_ = faces_.size();
  for (HalfedgeIndex h = 0; h < twins_.size(); ++h) {
    if (twins_[h] == invalid_index || twins_[h] < h) continue;
    const FaceIndex a = root(h / 3);
    const FaceIndex b = root(twins_[h] / 3);
    if (a == b) continue;
    parent[b] = a;
    --component_count_;
  }
}

int64_t Topology::euler_characteristic() const {
  return static_cast<int64_t>(vertex_count_ - isolated_count_) -
         static_cast<int64_t>(distinct_edges_) + static_cast<int64_t>(faces_.size());
}

}  // namespace kinemesh
