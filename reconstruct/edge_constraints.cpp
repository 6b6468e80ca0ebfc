#include "reconstruct/edge_constraints.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "reconstruct/delaunay_flips.h"

namespace kinemesh {
namespace {

bool contains(const std::vector<DirectedEdge>& list, VertexIndex a, VertexIndex b) {
  return std::find(list.begin(), list.end(), undirected(a, b)) != list.end();
}

/// The mesh around an edge to be, seen along the surface's normal.
class View {
 public:
  View(const EditMesh& mesh, const Points& points, VertexIndex a, VertexIndex b) : points_(points) {
    const Points normals = vertex_normals(mesh, points);
    Eigen::Vector3d normal = normals[a] + normals[b];
    normal = normal.norm() > 0 ? normal.normalized() : Eigen::Vector3d::UnitZ();
    x_ = normal.unitOrthogonal();
    y_ = normal.cross(x_);
  }
  /// Twice the signed area of a triangle, positive counter-clockwise.
  double turn(VertexIndex a, VertexIndex b, VertexIndex c) const {
    const auto flat = [this](VertexIndex v) {
      return Eigen::Vector2d(points_[v].dot(x_), points_[v].dot(y_));
    };
    const Eigen::Vector2d u = flat(b) - flat(a), w = flat(c) - flat(a);
    return u.x() * w.y() - u.y() * w.x();
  }
  bool cross(VertexIndex a, VertexIndex b, VertexIndex c, VertexIndex d) const {
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
  }

 private:
  const Points& points_;
  Eigen::Vector3d x_, y_;
};

/// The edges that the segment a–b crosses, from a on; empty where it leaves the mesh.
std::vector<DirectedEdge> crossed_edges(const EditMesh& mesh, const View& view, VertexIndex a,
                                        VertexIndex b) {
  std::vector<DirectedEdge> crossed;
  DirectedEdge gate{invalid_index, invalid_index};  // its far side lies on the left of [1] → [0]
  for (const auto& c : mesh.corners(a)) {
    if (view.cross(a, b, c.next, c.previous)) gate = {c.next, c.previous};
  }
  while (gate[0] != invalid_index && crossed.size() < 3 * mesh.face_count()) {
    crossed.push_back(gate);
    const VertexIndex apex = mesh.opposite(gate[1], gate[0]);
    if (apex == b) return crossed;
    if (apex == invalid_index) break;
    const DirectedEdge first{gate[0], apex}, second{apex, gate[1]};
    gate = view.cross(a, b, first[0], first[1])     ? first
           : view.cross(a, b, second[0], second[1]) ? second
                                                    : DirectedEdge{invalid_index, invalid_index};
  }
  return {};
}

}  // namespace

bool EdgeConstraints::forces(VertexIndex a, VertexIndex b) const { return contains(edges, a, b); }

bool force_edge(EditMesh& mesh, const Points& points, VertexIndex a, VertexIndex b,
                const std::vector<DirectedEdge>& keep) {
  EditMesh work = mesh;
  const View view(mesh, points, a, b);
  for (std::size_t round = 0; round < 10 * mesh.face_count() + 10; ++round) {
    if (work.has_edge(a, b)) {
      mesh = std::move(work);
      return true;
    }
    bool flipped = false;
    for (const auto& [p, q] : crossed_edges(work, view, a, b)) {
      const VertexIndex left = work.opposite(p, q);
      const VertexIndex right = work.opposite(q, p);
      const bool may = right != invalid_index && left != invalid_index && !contains(keep, p, q);
      // A flip inside the quadrilateral; one that crosses a–b again is made only when it must.
      if (may && view.cross(p, q, left, right) && work.flip(p, q)) {
        flipped = true;
        break;
      }
    }
    if (!flipped) return false;
  }
  return false;
}

bool remove_edge(EditMesh& mesh, VertexIndex a, VertexIndex b) {
  if (!mesh.has_edge(a, b)) return true;
  if (!mesh.is_boundary_edge(a, b)) return mesh.flip(a, b);
  if (!mesh.has_halfedge(a, b)) std::swap(a, b);
  if (mesh.is_boundary_vertex(mesh.opposite(a, b))) return false;
  mesh.remove_face(a, b);
  return true;
}

EdgeConstraints apply_constraints(EditMesh& mesh, const Points& points,
                                  const EdgeConstraints& constraints) {
  EdgeConstraints unmet;
  std::vector<DirectedEdge> done;
  for (const auto& e : constraints.edges) {
    const bool forced = force_edge(mesh, points, e[0], e[1], done);
    (forced ? done : unmet.edges).push_back(e);
  }
  for (const auto& e : constraints.no_edges) {
    if (!remove_edge(mesh, e[0], e[1])) unmet.no_edges.push_back(e);
  }
  return unmet;
}

}  // namespace kinemesh
