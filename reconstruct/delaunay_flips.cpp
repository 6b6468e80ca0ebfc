#include "reconstruct/delaunay_flips.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace kinemesh {
namespace {

/// Edges, the smaller vertex first.
using EdgeSet = std::set<DirectedEdge>;

EdgeSet set_of(const std::vector<DirectedEdge>& list) { return {list.begin(), list.end()}; }

/// Angle between sides b and c of the triangle whose third side is a.
double angle_opposite(double a, double b, double c) {
  const double cosine = (b * b + c * c - a * a) / (2 * b * c);
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

class Flipper {
 public:
  Flipper(EditMesh& mesh, const Points& points, const std::vector<DirectedEdge>& keep,
          const std::vector<DirectedEdge>& avoid)
      : mesh_(mesh), points_(points), keep_(set_of(keep)), avoid_(set_of(avoid)) {}

  /// Flips until nothing gains, with the normals of the mesh at the start.
  std::size_t run(const RunContext& ctx) {
    normals_ = vertex_normals(mesh_, points_);
    edges_ = inner_edges();
    gains_.resize(edges_.size());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      place_of_[edges_[i]] = i;
      gains_[i] = gain(edges_[i][0], edges_[i][1]);
      best_.insert({-gains_[i], i});
    }
    std::size_t flips = 0;
    const std::size_t limit = 4 * edges_.size() + 10;  // arc lengths are no exact metric
    for (; flips < limit && !best_.empty(); ++flips) {
      const auto [loss, i] = *best_.begin();
      if (!(-loss > 1e-7)) break;
      if (flips % 1024 == 0) ctx.check_cancelled();
      const auto [a, b] = edges_[i];
      const VertexIndex c = mesh_.opposite(a, b);
      const VertexIndex d = mesh_.opposite(b, a);
      mesh_.flip(a, b);
      place_of_.erase(edges_[i]);
      edges_[i] = undirected(c, d);
      place_of_[edges_[i]] = i;
      for (const VertexIndex end : {c, d}) {
        update(end, a);
        update(end, b);
      }
      update(c, d);
    }
    return flips;
  }

 private:
  std::vector<DirectedEdge> inner_edges() const {
    std::vector<DirectedEdge> list;
    for (const auto& e : mesh_.edges()) {
      if (!mesh_.is_boundary_edge(e[0], e[1]) && !keep_.contains(undirected(e[0], e[1])))
        list.push_back(e);
    }
    return list;
  }

  void update(VertexIndex a, VertexIndex b) {
    const auto at = place_of_.find(undirected(a, b));
    if (at == place_of_.end()) return;
    const std::size_t i = at->second;
    best_.erase({-gains_[i], i});
    gains_[i] = gain(a, b);
    best_.insert({-gains_[i], i});
  }

  double length(VertexIndex a, VertexIndex b) const {
    return arc_length(points_[a], normals_[a], points_[b], normals_[b]);
  }

  /// How much more the angles opposite a–b sum to than those opposite the other diagonal; not
  /// positive where a flip is impossible, forbidden, or would fold the surface.
  double gain(VertexIndex a, VertexIndex b) const {
    const VertexIndex c = mesh_.opposite(a, b);
    const VertexIndex d = mesh_.opposite(b, a);
    if (c == d || mesh_.has_edge(c, d) || avoid_.contains(undirected(c, d))) return 0.0;
    const double ab = length(a, b), cd = length(c, d);
    const double ac = length(a, c), ad = length(a, d), bc = length(b, c), bd = length(b, d);
    if (angle_opposite(bc, ab, ac) + angle_opposite(bd, ab, ad) >= std::numbers::pi ||
        angle_opposite(ac, ab, bc) + angle_opposite(ad, ab, bd) >= std::numbers::pi) {
      return 0.0;  // the quadrilateral is not convex
    }
    if (avoid_.contains(undirected(a, b))) return 2 * std::numbers::pi;
    if (folds(c, a, d) || folds(d, b, c)) return 0.0;
    const double g = angle_opposite(ab, bc, ac) + angle_opposite(ab, bd, ad) -
                     angle_opposite(cd, ac, ad) - angle_opposite(cd, bc, bd);
    return std::isfinite(g) ? g : 0.0;  // markers at one place have no angles
  }

  /// The triangle faces away from the surface around it.
  bool folds(VertexIndex a, VertexIndex b, VertexIndex c) const {
    const Eigen::Vector3d n = (points_[b] - points_[a]).cross(points_[c] - points_[a]);
    return n.dot(normals_[a] + normals_[b] + normals_[c]) <= 0;
  }

  EditMesh& mesh_;
  const Points& points_;
  EdgeSet keep_, avoid_;
  Points normals_;
  std::vector<DirectedEdge> edges_;                ///< inner ones, smaller vertex first
  std::vector<double> gains_;                      ///< of each
  std::map<DirectedEdge, std::size_t> place_of_;   ///< in edges_
  std::set<std::pair<double, std::size_t>> best_;  ///< (−gain, place), the best first
};

}  // namespace

Points vertex_normals(const EditMesh& mesh, const Points& points) {
  Points normals(points.size(), Eigen::Vector3d::Zero());
  for (VertexIndex v = 0; v < points.size(); ++v) {
    for (const auto& c : mesh.corners(v)) {
      const Eigen::Vector3d u = (points[c.next] - points[v]).normalized();
      const Eigen::Vector3d w = (points[c.previous] - points[v]).normalized();
      const Eigen::Vector3d n = u.cross(w);
      const double sine = n.norm();
      if (sine > 0) normals[v] += std::atan2(sine, u.dot(w)) / sine * n;
    }
    const double norm = normals[v].norm();
    if (norm > 0) normals[v] /= norm;
  }
  return normals;
}

double arc_length(const Eigen::Vector3d& p, const Eigen::Vector3d& normal_p,
                  const Eigen::Vector3d& q, const Eigen::Vector3d& normal_q) {
  const Eigen::Vector3d chord = q - p;
  const double length = chord.norm();
  if (length <= 0) return 0.0;
  const double a = -chord.dot(normal_p) / length;  // sine of the slope at p, positive where convex
  const double b = chord.dot(normal_q) / length;
  return length * std::min(1.6, 1 + (2 * a * a + 2 * b * b + a * b) / 30);
}

std::size_t flip_to_delaunay(EditMesh& mesh, const Points& points,
                             const std::vector<DirectedEdge>& keep,
                             const std::vector<DirectedEdge>& avoid, const RunContext& ctx) {
  constexpr int most_rounds = 6;  // each with normals of the mesh that the one before left
  std::size_t total = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const std::size_t flips = Flipper(mesh, points, keep, avoid).run(ctx);
    total += flips;
    if (flips == 0) break;
  }
  return total;
}

}  // namespace kinemesh
