#include "reconstruct/surface_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

namespace kinemesh {
namespace {

double area(const Points& p, const Triangle& t) {
  return 0.5 * (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm();
}

/// A group of faces: more vertices (or faces) first, then larger area.
struct Group {
  std::size_t count = 0;
  double area = 0.0;
  std::vector<Triangle> faces;
  bool operator<(const Group& o) const { return std::tie(count, area) < std::tie(o.count, o.area); }
};

Group component_of(const EditMesh& mesh, const Points& points, VertexIndex seed,
                   std::vector<bool>& seen) {
  Group group;
  std::vector<VertexIndex> stack{seed};
  seen[seed] = true;
  while (!stack.empty()) {
    const VertexIndex v = stack.back();
    stack.pop_back();
    ++group.count;
    for (const auto& c : mesh.corners(v)) {
      if (v < c.next && v < c.previous) {
        group.faces.push_back({v, c.next, c.previous});
        group.area += area(points, group.faces.back());
      }
      for (const VertexIndex w : {c.next, c.previous}) {
        if (!seen[w]) stack.push_back(w);
        seen[w] = true;
      }
    }
  }
  return group;
}

/// The faces of v as fans.
std::vector<Group> fans_of(const EditMesh& mesh, const Points& points, VertexIndex v) {
  std::vector<Group> fans;
  std::vector<VertexIndex> starts;
  for (const auto& c : mesh.corners(v)) {
    if (!mesh.has_halfedge(c.next, v)) starts.push_back(c.next);
  }
  for (const VertexIndex start : starts) {
    Group fan;
    for (VertexIndex at = start; mesh.has_halfedge(v, at);) {
      const VertexIndex next = mesh.opposite(v, at);
      fan.faces.push_back({v, at, next});
      fan.area += area(points, fan.faces.back());
      ++fan.count;
      at = next;
    }
    fans.push_back(std::move(fan));
  }
  return fans;
}

void remove_faces(EditMesh& mesh, const std::vector<Triangle>& faces) {
  for (const Triangle& t : faces) mesh.remove_face(t[0], t[1]);
}

}  // namespace

void keep_largest_component(EditMesh& mesh, const Points& points) {
  std::vector<bool> seen(mesh.vertex_count(), false);
  std::vector<Group> groups;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
    if (!seen[v] && mesh.has_vertex(v)) groups.push_back(component_of(mesh, points, v, seen));
  }
  if (groups.size() < 2) return;
  const auto largest = std::max_element(groups.begin(), groups.end());
  for (auto group = groups.begin(); group != groups.end(); ++group) {
    if (group != largest) remove_faces(mesh, group->faces);
  }
}

void mend_pinches(EditMesh& mesh, const Points& points) {
  for (bool changed = true; changed;) {
    changed = false;
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
      if (mesh.has_one_fan(v)) continue;
      const auto fans = fans_of(mesh, points, v);
      if (fans.size() < 2) continue;  // a closed fan beside an open one cannot be told apart
      const auto largest = std::max_element(fans.begin(), fans.end());
      for (auto fan = fans.begin(); fan != fans.end(); ++fan) {
        if (fan != largest) remove_faces(mesh, fan->faces);
      }
      changed = true;
    }
  }
}

double orient_outwards(EditMesh& mesh, const Points& points) {
  double volume = 0.0;
  double total = 0.0;
  const auto cone = [](const auto& a, const auto& b, const auto& c) {
    return a.dot(b.cross(c)) / 6;
  };
  for (const auto& t : mesh.triangles()) {
    volume += cone(points[t[0]], points[t[1]], points[t[2]]);
    total += area(points, t);
  }
  for (const auto& loop : mesh.boundary_loops()) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const VertexIndex v : loop) centre += points[v] / static_cast<double>(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      volume += cone(points[loop[(i + 1) % loop.size()]], points[loop[i]], centre);
    }
  }
  if (volume < 0) mesh.reverse_orientation();
  return total > 0 ? std::abs(volume) / std::pow(total, 1.5) : 0.0;
}

std::size_t trim_rim(EditMesh& mesh, const Points& points, const MarkerSpacing& spacing,
                     double bound, const std::vector<DirectedEdge>& keep) {
  std::size_t removed = 0;
  for (;;) {
    double longest = 1.0;
    DirectedEdge worst{invalid_index, invalid_index};
    for (const auto& [a, b] : mesh.edges()) {
      if (!mesh.is_boundary_edge(a, b)) continue;
      const VertexIndex apex = mesh.opposite(a, b);
      if (mesh.is_boundary_vertex(apex)) continue;  // would pinch, or leave a vertex alone
      if (std::find(keep.begin(), keep.end(), DirectedEdge{std::min(a, b), std::max(a, b)}) !=
          keep.end())
        continue;
      const double local = 0.5 * (spacing.of_vertex[a] + spacing.of_vertex[b]);
      const double limit = bound * std::min(local, spacing.mean);
      const double ratio = (points[a] - points[b]).norm() / limit;
      if (ratio > longest) {
        longest = ratio;
        worst = {a, b};
      }
    }
    if (worst[0] == invalid_index) return removed;
    mesh.remove_face(worst[0], worst[1]);
    ++removed;
  }
}

}  // namespace kinemesh
