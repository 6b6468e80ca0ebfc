#include "tests/support/triangulation_score.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "tests/support/closest_point.h"

namespace kinemesh::test {

namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool inside(const Polygon& polygon, const Eigen::Vector2d& p) {
  bool in = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) {
      in = !in;
    }
  }
  return in;
}

bool segments_cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                    const Eigen::Vector2d& d) {
  return cross(b - a, c - a) * cross(b - a, d - a) < 0 &&
         cross(d - c, a - c) * cross(d - c, b - c) < 0;
}

/// Domain coordinates of the reference's sites: that of the closest point of its surface.
std::vector<Eigen::Vector2d> site_domain(const GeodesicDelaunay& reference,
                                         const ClosestPoint& surface) {
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Vector3d& p : reference.sites) {
    const auto hit = surface.closest(p);
    const Triangle& face = reference.surface.topology->faces()[hit.face];
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int k = 0; k < 3; ++k) sum += hit.weights[k] * reference.surface.domain[face[k]];
    places.push_back(sum);
  }
  return places;
}

/// Most of the triangle's area lies in the polygon.
bool mostly_inside(const Triangle& t, const std::vector<Eigen::Vector2d>& places,
                   const Polygon& polygon) {
  constexpr int n = 7;
  int in = 0, all = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j, ++all) {
      const double a = (i + 1.0 / 3) / n, b = (j + 1.0 / 3) / n;
      in +=
          inside(polygon, a * places[t[0]] + b * places[t[1]] + (1 - a - b) * places[t[2]]) ? 1 : 0;
    }
  }
  return 2 * in > all;
}

template <class Loop>
Polygon polygon_of(const Loop& loop, const std::vector<Eigen::Vector2d>& places) {
  Polygon polygon;
  for (const auto v : loop) polygon.push_back(places[v]);
  return polygon;
}

double perimeter(const std::vector<VertexIndex>& loop, const std::vector<Eigen::Vector3d>& p) {
  double sum = 0;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    sum += (p[loop[k]] - p[loop[(k + 1) % loop.size()]]).norm();
  }
  return sum;
}

/// All boundary loops but the longest, which is the outer rim.
std::vector<std::vector<VertexIndex>> inner_loops(const Topology& mesh,
                                                  const std::vector<Eigen::Vector3d>& sites) {
  auto loops = mesh.boundary_loops();
  const auto outer = std::max_element(
      loops.begin(), loops.end(),
      [&](const auto& a, const auto& b) { return perimeter(a, sites) < perimeter(b, sites); });
  if (outer != loops.end()) loops.erase(outer);
  return loops;
}

/// Edges of the mesh over the slit; one that goes around its corner along the surface, as an edge
/// of the reference does, is none.
std::size_t crossings(const Topology& mesh, const std::vector<Eigen::Vector2d>& places,
                      const Slit& slit, const GeodesicDelaunay& reference) {
  const std::vector<Eigen::Vector2d>& domain = reference.surface.domain;
  std::size_t count = 0;
  for (const Edge& e : mesh.edges()) {
    if (reference.find(e.vertices[0], e.vertices[1]) != nullptr) continue;
    bool crosses = false;
    for (std::size_t k = 0; k + 1 < slit.upper.size(); ++k) {
      crosses |= segments_cross(places[e.vertices[0]], places[e.vertices[1]], domain[slit.upper[k]],
                                domain[slit.upper[k + 1]]);
    }
    count += crosses ? 1 : 0;
  }
  return count;
}

void score_openings(const Topology& mesh, const GeodesicDelaunay& reference,
                    const ClosestPoint& surface, TriangulationScore& score) {
  const auto places = site_domain(reference, surface);
  const auto loops = inner_loops(mesh, reference.sites);
  std::vector<bool> used(loops.size(), false);
  score.openings_right = true;
  for (std::size_t k = 0; k < reference.openings.size(); ++k) {
    const auto& truth = reference.openings[k];
    const Slit& slit = reference.surface.slits[k];
    OpeningScore o{truth.name, false, 0, truth.ring.size(), 0, 0};
    const Eigen::Vector2d middle = reference.surface.domain[slit.upper[slit.upper.size() / 2]];
    const Polygon true_hole = polygon_of(truth.ring, places);
    for (std::size_t l = 0; l < loops.size(); ++l) {
      const Polygon hole = polygon_of(loops[l], places);
      if (used[l] || !inside(hole, middle)) continue;
      used[l] = o.found = true;
      o.ring_size = loops[l].size();
      for (const Triangle& t : reference.triangles) {
        o.differing_triangles += mostly_inside(t, places, hole) ? 1 : 0;
      }
    }
    for (const Triangle& t : mesh.faces()) {
      o.differing_triangles += mostly_inside(t, places, true_hole) ? 1 : 0;
    }
    o.edges_across = crossings(mesh, places, slit, reference);
    score.edges_across += o.edges_across;
    score.openings_right &= o.found;
    score.openings.push_back(std::move(o));
  }
  score.false_openings = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
  score.openings_right &= score.false_openings == 0;
}

void score_edges(const Topology& mesh, const GeodesicDelaunay& reference,
                 TriangulationScore& score) {
  std::size_t right = 0;
  std::set<std::array<uint32_t, 2>> edges;
  const std::vector<double> local = local_spacing(reference.sites);
  for (const Edge& e : mesh.edges()) {
    const auto [a, b] = std::minmax(e.vertices[0], e.vertices[1]);
    edges.insert({a, b});
    right += reference.find(a, b) != nullptr ? 1 : 0;
    if (!e.boundary()) continue;
    const double length = (reference.sites[a] - reference.sites[b]).norm();
    score.longest_rim_edge = std::max(score.longest_rim_edge, length / reference.spacing);
    score.longest_rim_edge_local =
        std::max(score.longest_rim_edge_local, 2 * length / (local[a] + local[b]));
  }
  std::size_t core = 0, found = 0;
  for (const auto& e : reference.edges) {
    core += e.core ? 1 : 0;
    found += e.core && edges.contains(e.sites) ? 1 : 0;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  score.precision = share(right, mesh.edge_count());
  score.recall = share(found, core);
}

/// Which of the reference's triangles touch its outer rim with an edge, and which edges are
/// boundary at all.
class Region {
 public:
  explicit Region(const GeodesicDelaunay& reference)
      : reference_(reference), mesh_(reference.sites, reference.triangles, reference.spacing) {
    for (const Triangle& t : reference.triangles) {
      for (int k = 0; k < 3; ++k) ++uses_[key(t[k], t[(k + 1) % 3])];
    }
  }
  bool contains(const Eigen::Vector3d& p) const {
    const auto hit = mesh_.closest(p);
    const Triangle& t = reference_.triangles[hit.face];
    if (hit.weights.maxCoeff() > 1 - 1e-9) return false;  // beyond a corner of the rim
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = t[k], b = t[(k + 1) % 3];
      if (uses_.at(key(a, b)) != 1) continue;
      const auto* edge = reference_.find(a, b);
      const bool outer = edge == nullptr || edge->rim;
      if (outer || hit.weights[(k + 2) % 3] < 1e-9) return false;
    }
    return true;
  }

 private:
  static std::pair<uint32_t, uint32_t> key(uint32_t a, uint32_t b) { return std::minmax(a, b); }
  const GeodesicDelaunay& reference_;
  ClosestPoint mesh_;
  std::map<std::pair<uint32_t, uint32_t>, int> uses_;
};

struct Squares {
  double sum = 0, weight = 0;
  void add(double distance, double w) {
    sum += w * distance * distance;
    weight += w;
  }
};

double triangle_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return 0.5 * (b - a).cross(c - a).norm();
}

class SurfaceScorer {
 public:
  explicit SurfaceScorer(const GeodesicDelaunay& reference)
      : reference_(reference),
        surface_(reference.surface.positions, reference.surface.topology->faces(), 4.0) {
    const Region region(reference);
    const auto& p = reference.surface.positions;
    for (const Triangle& t : reference.surface.topology->faces()) {
      const Eigen::Vector3d centre = (p[t[0]] + p[t[1]] + p[t[2]]) / 3;
      if (region.contains(centre))
        samples_.emplace_back(centre, triangle_area(p[t[0]], p[t[1]], p[t[2]]));
    }
  }
  const ClosestPoint& surface() const { return surface_; }

  double rms(const std::vector<Triangle>& triangles) const {
    if (triangles.empty()) return 0;
    Squares squares;
    const auto& s = reference_.sites;
    for (const Triangle& t : triangles) {
      constexpr int n = 6, count = n * (n + 1) / 2;
      const double area = triangle_area(s[t[0]], s[t[1]], s[t[2]]);
      for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
          const double a = (i + 1.0 / 3) / n, b = (j + 1.0 / 3) / n;
          const Eigen::Vector3d p = a * s[t[0]] + b * s[t[1]] + (1 - a - b) * s[t[2]];
          squares.add(surface_.closest(p).distance, area / count);
        }
      }
    }
    const ClosestPoint mesh(s, triangles, reference_.spacing);
    for (const auto& [p, area] : samples_) squares.add(mesh.closest(p).distance, area);
    return std::sqrt(squares.sum / squares.weight);
  }

 private:
  const GeodesicDelaunay& reference_;
  ClosestPoint surface_;
  std::vector<std::pair<Eigen::Vector3d, double>> samples_;
};

/// Most triangles face the same way as the surface below them.
bool faces_outwards(const Topology& mesh, const GeodesicDelaunay& reference,
                    const ClosestPoint& surface) {
  std::size_t agree = 0;
  const auto normal = [](const auto& p, const Triangle& t) -> Eigen::Vector3d {
    return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
  };
  for (const Triangle& t : mesh.faces()) {
    const auto& s = reference.sites;
    const auto hit = surface.closest((s[t[0]] + s[t[1]] + s[t[2]]) / 3);
    const Eigen::Vector3d below =
        normal(reference.surface.positions, reference.surface.topology->faces()[hit.face]);
    agree += normal(s, t).dot(below) > 0 ? 1 : 0;
  }
  return 2 * agree > mesh.face_count();
}

}  // namespace

double rms_to_surface(const std::vector<Triangle>& triangles, const GeodesicDelaunay& reference) {
  return SurfaceScorer(reference).rms(triangles);
}

TriangulationScore score_triangulation(const Topology& mesh, const GeodesicDelaunay& reference) {
  TriangulationScore score;
  score.manifold = mesh.is_manifold();
  score.all_markers = mesh.isolated_vertex_count() == 0;
  score.components = mesh.component_count();
  score.euler = mesh.euler_characteristic();
  score_edges(mesh, reference, score);
  const SurfaceScorer scorer(reference);
  score.rms_mm = scorer.rms(mesh.faces());
  score.reference_rms_mm = scorer.rms(reference.triangles);
  score.rms_ratio = score.rms_mm / score.reference_rms_mm;
  score.outwards = faces_outwards(mesh, reference, scorer.surface());
  if (!reference.surface.domain.empty()) {
    score_openings(mesh, reference, scorer.surface(), score);
  } else {
    score.openings_right = true;
  }
  return score;
}

std::string TriangulationScore::summary() const {
  std::ostringstream text;
  text.precision(3);
  text << "precision " << precision << " recall " << recall << " rms " << rms_mm << " ratio "
       << rms_ratio << " rim " << longest_rim_edge << " (local " << longest_rim_edge_local
       << ") components " << components << " euler " << euler << (manifold ? "" : " NOT MANIFOLD")
       << (all_markers ? "" : " MARKERS LOST") << (outwards ? "" : " INSIDE OUT");
  for (const OpeningScore& o : openings) {
    text << " | " << o.name << (o.found ? " ring " : " MISSING ring ") << o.ring_size << "/"
         << o.true_ring_size << " differing " << o.differing_triangles << " across "
         << o.edges_across;
  }
  if (false_openings > 0) text << " | FALSE OPENINGS " << false_openings;
  return text.str();
}

}  // namespace kinemesh::test
