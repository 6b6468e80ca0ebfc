// insert_missing_vertices(): see surface_repair.h.
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "reconstruct/surface_repair.h"

namespace kinemesh {
namespace {

/// The point of a triangle nearest to p, as weights of its corners (Ericson, Real-Time Collision
/// Detection, 2005, section 5.1.5).
Eigen::Vector3d nearest_weights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a;
  const double d1 = ab.dot(p - a), d2 = ac.dot(p - a);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(p - b), d4 = ac.dot(p - b);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const double d5 = ab.dot(p - c), d6 = ac.dot(p - c);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  return Eigen::Vector3d(va, vb, vc) / (va + vb + vc);
}

struct Nearest {
  Triangle face{};
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  double distance = std::numeric_limits<double>::infinity();
};

Nearest nearest_face(const std::vector<Triangle>& faces, const Points& points, VertexIndex v) {
  Nearest best;
  for (const Triangle& t : faces) {
    const auto weights = nearest_weights(points[v], points[t[0]], points[t[1]], points[t[2]]);
    const Eigen::Vector3d foot =
        weights[0] * points[t[0]] + weights[1] * points[t[1]] + weights[2] * points[t[2]];
    const double distance = (points[v] - foot).norm();
    if (distance < best.distance) best = {t, weights, distance};
  }
  return best;
}

void split_face(EditMesh& mesh, const Triangle& t, VertexIndex v) {
  mesh.remove_face(t[0], t[1]);
  for (int i = 0; i < 3; ++i) mesh.add_face(t[i], t[(i + 1) % 3], v);
}

void split_edge(EditMesh& mesh, VertexIndex a, VertexIndex b, VertexIndex v) {
  const VertexIndex left = mesh.opposite(a, b);
  const VertexIndex right = mesh.opposite(b, a);
  mesh.remove_face(a, b);
  mesh.remove_face(b, a);
  mesh.add_face(a, v, left);
  mesh.add_face(v, b, left);
  mesh.add_face(b, v, right);
  mesh.add_face(v, a, right);
}

/// The boundary edge at a vertex whose middle is nearest to p.
DirectedEdge boundary_edge_at(const EditMesh& mesh, const Points& points, VertexIndex corner,
                              const Eigen::Vector3d& p) {
  DirectedEdge best{invalid_index, invalid_index};
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](VertexIndex from, VertexIndex to) {
    if (mesh.has_halfedge(to, from)) return;
    const double distance = (p - 0.5 * (points[from] + points[to])).norm();
    if (distance < least) {
      least = distance;
      best = {from, to};
    }
  };
  for (const auto& c : mesh.corners(corner)) {
    consider(corner, c.next);
    consider(c.previous, corner);
  }
  return best;
}

void insert_vertex(EditMesh& mesh, const Points& points, const Nearest& place, VertexIndex v) {
  constexpr double on_edge = 0.05;  // a corner's weight below this puts the foot on the other edge
  const Triangle& t = place.face;
  int low = 0;
  int high = 0;
  for (int i = 1; i < 3; ++i) {
    if (place.weights[i] < place.weights[low]) low = i;
    if (place.weights[i] > place.weights[high]) high = i;
  }
  if (place.weights[low] >= on_edge) return split_face(mesh, t, v);
  DirectedEdge edge{t[(low + 1) % 3], t[(low + 2) % 3]};
  if (place.weights[high] > 1 - 1e-9 && mesh.is_boundary_vertex(t[high])) {
    edge = boundary_edge_at(mesh, points, t[high], points[v]);
  }
  if (mesh.has_halfedge(edge[1], edge[0])) {
    split_edge(mesh, edge[0], edge[1], v);
  } else if (place.weights[low] <= 0) {
    mesh.add_face(edge[1], edge[0], v);
  } else {
    split_face(mesh, t, v);
  }
}

}  // namespace

std::size_t insert_missing_vertices(EditMesh& mesh, const Points& points) {
  std::size_t inserted = 0;
  for (;;) {
    Nearest best;
    VertexIndex vertex = invalid_index;
    const auto faces = mesh.triangles();
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
      if (mesh.has_vertex(v)) continue;
      const Nearest place = nearest_face(faces, points, v);
      if (vertex == invalid_index || place.distance < best.distance) {
        best = place;
        vertex = v;
      }
    }
    if (vertex == invalid_index || faces.empty()) return inserted;
    insert_vertex(mesh, points, best, vertex);
    if (!mesh.has_vertex(vertex)) return inserted;
    ++inserted;
  }
}

}  // namespace kinemesh
