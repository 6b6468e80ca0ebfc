#include "reconstruct/edit_mesh.h"

#include <algorithm>

#include "config/error.h"

namespace kinemesh {

EditMesh::EditMesh(std::size_t vertex_count, const std::vector<Triangle>& triangles)
    : out_(vertex_count) {
  for (const auto& [a, b, c] : triangles) add_face(a, b, c);
}

VertexIndex EditMesh::opposite(VertexIndex from, VertexIndex to) const {
  for (const Corner& corner : out_[from]) {
    if (corner.next == to) return corner.previous;
  }
  return invalid_index;
}

bool EditMesh::is_boundary_vertex(VertexIndex v) const {
  return std::any_of(out_[v].begin(), out_[v].end(), [&](const Corner& c) {
    return !has_halfedge(c.next, v) || !has_halfedge(v, c.previous);
  });
}

bool EditMesh::has_one_fan(VertexIndex v) const {
  if (out_[v].empty()) return true;
  // Walk from the face without a right neighbour, or from any, until the fan ends or closes.
  VertexIndex start = out_[v].front().next;
  for (const Corner& c : out_[v]) {
    if (!has_halfedge(c.next, v)) start = c.next;
  }
  std::size_t visited = 0;
  VertexIndex at = start;
  do {
    const VertexIndex previous = opposite(v, at);
    if (previous == invalid_index) break;
    ++visited;
    at = previous;
  } while (at != start && visited <= out_[v].size());
  return visited == out_[v].size();
}

bool EditMesh::add_face(VertexIndex a, VertexIndex b, VertexIndex c) {
  if (a == b || b == c || c == a) return false;
  if (has_halfedge(a, b) || has_halfedge(b, c) || has_halfedge(c, a)) return false;
  out_[a].push_back({b, c});
  out_[b].push_back({c, a});
  out_[c].push_back({a, b});
  ++face_count_;
  return true;
}

void EditMesh::remove_face(VertexIndex from, VertexIndex to) {
  const VertexIndex third = opposite(from, to);
  if (third == invalid_index) throw InternalError("a face was removed that does not exist");
  const auto drop = [this](VertexIndex v, VertexIndex next) {
    auto& corners = out_[v];
    corners.erase(std::find_if(corners.begin(), corners.end(),
                               [&](const Corner& c) { return c.next == next; }));
  };
  drop(from, to);
  drop(to, third);
  drop(third, from);
  --face_count_;
}

bool EditMesh::flip(VertexIndex a, VertexIndex b) {
  const VertexIndex left = opposite(a, b);
  const VertexIndex right = opposite(b, a);
  if (left == invalid_index || right == invalid_index || left == right || has_edge(left, right)) {
    return false;
  }
  remove_face(a, b);
  remove_face(b, a);
  add_face(left, a, right);
  add_face(right, b, left);
  return true;
}

void EditMesh::reverse_orientation() {
  for (auto& corners : out_) {
    for (Corner& c : corners) std::swap(c.next, c.previous);
  }
}

std::vector<VertexIndex> EditMesh::neighbours(VertexIndex v) const {
  std::vector<VertexIndex> ring;
  for (const Corner& c : out_[v]) {
    ring.push_back(c.next);
    ring.push_back(c.previous);
  }
  std::sort(ring.begin(), ring.end());
  ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  return ring;
}

std::vector<Triangle> EditMesh::triangles() const {
  std::vector<Triangle> faces;
  faces.reserve(face_count_);
  for (VertexIndex v = 0; v < out_.size(); ++v) {
    for (const Corner& c : out_[v]) {
      if (v < c.next && v < c.previous) faces.push_back({v, c.next, c.previous});
    }
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

std::vector<DirectedEdge> EditMesh::edges() const {
  std::vector<DirectedEdge> list;
  list.reserve(2 * face_count_);
  for (VertexIndex v = 0; v < out_.size(); ++v) {
    for (const Corner& c : out_[v]) {
      if (v < c.next || !has_halfedge(c.next, v)) list.push_back({v, c.next});
    }
  }
  std::sort(list.begin(), list.end());
  return list;
}

std::vector<std::vector<VertexIndex>> EditMesh::boundary_loops() const {
  // Where fans meet at one vertex, a loop continues over the fan it came along.
  std::vector<DirectedEdge> open;
  for (VertexIndex v = 0; v < out_.size(); ++v) {
    for (const Corner& c : out_[v]) {
      if (!has_halfedge(c.next, v)) open.push_back({v, c.next});
    }
  }
  std::sort(open.begin(), open.end());
  std::vector<bool> traced(open.size(), false);
  const auto index_of = [&](VertexIndex from, VertexIndex to) {
    return static_cast<std::size_t>(
        std::lower_bound(open.begin(), open.end(), DirectedEdge{from, to}) - open.begin());
  };
  std::vector<std::vector<VertexIndex>> loops;
  for (std::size_t first = 0; first < open.size(); ++first) {
    std::vector<VertexIndex> loop;
    for (std::size_t i = first; !traced[i];) {
      traced[i] = true;
      const VertexIndex from = open[i][0];
      const VertexIndex pivot = open[i][1];
      loop.push_back(from);
      VertexIndex next = opposite(from, pivot);  // turn about the pivot to the fan's other end
      while (has_halfedge(next, pivot)) next = opposite(next, pivot);
      i = index_of(pivot, next);
    }
    if (!loop.empty()) loops.push_back(std::move(loop));
  }
  return loops;
}

int64_t EditMesh::euler_characteristic() const {
  const auto vertices = std::count_if(out_.begin(), out_.end(), [](auto& c) { return !c.empty(); });
  return vertices - static_cast<int64_t>(edges().size()) + static_cast<int64_t>(face_count_);
}

}  // namespace kinemesh
