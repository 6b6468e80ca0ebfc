#include "reconstruct/strip.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "config/error.h"

namespace kinemesh {
namespace {

struct Scored {
  DirectedEdge edge;
  double score;
};

class StripGrower {
 public:
  StripGrower(const EditMesh& mesh, const StripRule& rule)
      : mesh_(mesh), rule_(rule), used_(mesh.vertex_count(), false) {}

  Strip grow(const Scored& seed) {
    Strip strip;
    const auto [a, b] = seed.edge;
    if (!free_edge(a, b)) return strip;
    std::vector<Scored> forward{seed}, backward;
    taken_ = {a, b};
    threshold_ = std::max(rule_.floor, rule_.share * rule_.contrast(a, b));
    bridge_ = std::max(threshold_, 0.5 * rule_.contrast(a, b));
    grow_one_way(a, b, forward);
    grow_one_way(b, a, backward);
    std::vector<Scored> all(backward.rbegin(), backward.rend());
    all.insert(all.end(), forward.begin(), forward.end());
    shorten_to_free_corners(all);
    for (const Scored& e : all) {
      strip.edges.push_back(e.edge);
      strip.strengths.push_back(e.score);
      strip.peak = std::max(strip.peak, e.score);
      strip.sum += e.score;
    }
    for (const Scored& e : all) used_[e.edge[0]] = used_[e.edge[1]] = true;
    if (!all.empty()) used_[corner(all, true)] = used_[corner(all, false)] = true;
    return strip;
  }

 private:
  bool usable(VertexIndex v) const { return !used_[v] && !mesh_.is_boundary_vertex(v); }
  bool free_edge(VertexIndex a, VertexIndex b) const { return usable(a) && usable(b); }

  /// Over the triangle on the left of a → b and on.
  void grow_one_way(VertexIndex a, VertexIndex b, std::vector<Scored>& edges) {
    for (;;) {
      const VertexIndex apex = mesh_.opposite(a, b);
      if (apex == invalid_index || !usable(apex) || taken_.contains(apex)) return;
      const double over_a = rule_.contrast(a, apex);  // keeps a, leaves b behind
      const double over_b = rule_.contrast(b, apex);
      if (std::max(over_a, over_b) <= threshold_) {
        if (!bridge(a, b, edges)) return;
        continue;
      }
      taken_.insert(apex);
      if (over_a >= over_b) {
        b = apex;
      } else {
        a = apex;
      }
      edges.push_back({undirected(a, b), rule_.strength(a, b)});
      // The next triangle lies beyond the new edge, on its left in this direction.
    }
  }

  /// Over up to three doubtful edges to the next strong one, by the shortest way. Moves a → b and
  /// lists the edges; false, and no change, where there is no such way.
  bool bridge(VertexIndex& a, VertexIndex& b, std::vector<Scored>& edges) {
    for (int doubtful = 1; doubtful <= 3; ++doubtful) {
      std::vector<DirectedEdge> way;
      if (!find_way(a, b, doubtful, way)) continue;
      for (const auto& [p, q] : way) {
        taken_.insert({p, q});
        edges.push_back({undirected(p, q), rule_.strength(p, q)});
      }
      a = way.back()[0];
      b = way.back()[1];
      return true;
    }
    return false;
  }

  bool find_way(VertexIndex a, VertexIndex b, int doubtful, std::vector<DirectedEdge>& way) const {
    const VertexIndex apex = mesh_.opposite(a, b);
    if (apex == invalid_index || !usable(apex) || taken_.contains(apex)) return false;
    for (const DirectedEdge& next : {DirectedEdge{a, apex}, DirectedEdge{apex, b}}) {
      way.push_back(next);
      if (doubtful == 0
              ? rule_.contrast(next[0], next[1]) > bridge_
              : rule_.doubtful(next[0], next[1]) && find_way(next[0], next[1], doubtful - 1, way)) {
        return true;
      }
      way.pop_back();
    }
    return false;
  }

  /// The triangles at the ends bring a corner each, which must be free and not of the strip.
  void shorten_to_free_corners(std::vector<Scored>& edges) const {
    while (!edges.empty()) {
      const VertexIndex front = corner(edges, true);
      const VertexIndex back = corner(edges, false);
      if (!is_free_corner(front, edges)) {
        edges.erase(edges.begin());
      } else if (!is_free_corner(back, edges) || front == back) {
        edges.pop_back();
      } else {
        return;
      }
    }
  }

  bool is_free_corner(VertexIndex v, const std::vector<Scored>& edges) const {
    return v != invalid_index && usable(v) &&
           std::none_of(edges.begin(), edges.end(),
                        [v](const Scored& e) { return e.edge[0] == v || e.edge[1] == v; });
  }

  /// The vertex opposite the first (last) edge on its outer side.
  VertexIndex corner(const std::vector<Scored>& edges, bool first) const {
    const DirectedEdge end = first ? edges.front().edge : edges.back().edge;
    const VertexIndex left = mesh_.opposite(end[0], end[1]);
    const VertexIndex right = mesh_.opposite(end[1], end[0]);
    if (edges.size() == 1) return first ? left : right;
    const DirectedEdge inner = first ? edges[1].edge : edges[edges.size() - 2].edge;
    return inner[0] == left || inner[1] == left ? right : left;
  }

  const EditMesh& mesh_;
  const StripRule& rule_;
  std::vector<bool> used_;
  std::set<VertexIndex> taken_;
  double threshold_ = 0.0;
  double bridge_ = 0.0;
};

/// +1 and −1 for the vertices on either side of the strip.
std::map<VertexIndex, int> sides_of(const Strip& strip) {
  std::map<VertexIndex, int> side{{strip.edges.front()[0], 1}, {strip.edges.front()[1], -1}};
  for (const auto& [a, b] : strip.edges) {
    if (!side.contains(a)) side[a] = -side.at(b);
    if (!side.contains(b)) side[b] = -side.at(a);
  }
  return side;
}

std::vector<VertexIndex> loop_through(const EditMesh& mesh, VertexIndex v) {
  for (auto& loop : mesh.boundary_loops()) {
    if (std::find(loop.begin(), loop.end(), v) != loop.end()) return loop;
  }
  throw InternalError("a strip was cut that left no loop");
}

/// Angle of the opening at b between its loop neighbours a and c: what the faces at b leave of a
/// full turn, but no less than the plain angle.
double hole_angle(const EditMesh& mesh, const Points& p, VertexIndex a, VertexIndex b,
                  VertexIndex c) {
  const auto angle = [&](VertexIndex u, VertexIndex w) {
    const Eigen::Vector3d s = p[u] - p[b], t = p[w] - p[b];
    return std::atan2(s.cross(t).norm(), s.dot(t));
  };
  double taken = 0.0;
  for (const auto& corner : mesh.corners(b)) taken += angle(corner.next, corner.previous);
  return std::max(angle(a, c), 2 * std::numbers::pi - taken);
}

/// The line of a slit in the surface, from the middles of edges across it.
struct SlitLine {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< in which lips part, unit or 0

  /// Into the face, the third direction, the slit may bend.
  double distance(const Eigen::Vector3d& p) const { return std::abs((p - centre).dot(across)); }
};

SlitLine line_through(const std::vector<DirectedEdge>& edges, const Points& points,
                      std::size_t begin, std::size_t end) {
  const auto middle = [&](std::size_t i) -> Eigen::Vector3d {
    return 0.5 * (points[edges[i][0]] + points[edges[i][1]]);
  };
  SlitLine line;
  for (std::size_t i = begin; i < end; ++i)
    line.centre += middle(i) / static_cast<double>(end - begin);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = begin; i < end; ++i) {
    covariance += (middle(i) - line.centre) * (middle(i) - line.centre).transpose();
    const Eigen::Vector3d edge = points[edges[i][0]] - points[edges[i][1]];
    line.across += edge.dot(line.across) < 0 ? Eigen::Vector3d(-edge) : edge;
  }
  const Eigen::Vector3d along =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(2);
  line.across -= line.across.dot(along) * along;
  if (line.across.norm() > 0) line.across.normalize();
  return line;
}

/// Number of edges at the end of the strip that share `pivot`.
std::size_t fan_length(const std::vector<DirectedEdge>& edges, VertexIndex pivot, bool front) {
  std::size_t run = 0;
  while (run < edges.size()) {
    const DirectedEdge& e = front ? edges[run] : edges[edges.size() - 1 - run];
    if (e[0] != pivot && e[1] != pivot) break;
    ++run;
  }
  return run;
}

/// Edges to drop at one end, see drop_corner_fans().
std::size_t corner_fan(const Strip& strip, const Points& points, const SlitLine& line, double near,
                       bool front) {
  constexpr double weak = 0.6;  // of the strongest edge
  std::size_t longest = 0;
  for (const VertexIndex pivot : front ? strip.edges.front() : strip.edges.back()) {
    if (line.distance(points[pivot]) >= near) continue;
    const auto run = static_cast<std::ptrdiff_t>(fan_length(strip.edges, pivot, front));
    const auto begin = front ? strip.strengths.begin() : strip.strengths.end() - run;
    if (*std::max_element(begin, begin + run) >= weak * strip.peak) continue;
    // The innermost edge may still cross the tip of the slit: it stays in the strip.
    longest = std::max(longest, static_cast<std::size_t>(run - 1));
  }
  return longest;
}

}  // namespace

std::vector<Strip> find_strips(const EditMesh& mesh, const StripRule& rule) {
  std::vector<Scored> seeds;
  for (const auto& e : mesh.edges()) {
    if (mesh.is_boundary_edge(e[0], e[1])) continue;
    const double s = rule.strength(e[0], e[1]);
    if (s >= rule.seed) seeds.push_back({e, s});
  }
  std::stable_sort(seeds.begin(), seeds.end(),
                   [](const Scored& a, const Scored& b) { return a.score > b.score; });
  StripGrower grower(mesh, rule);
  std::vector<Strip> strips;
  for (const Scored& seed : seeds) {
    Strip strip = grower.grow(seed);
    if (!strip.edges.empty()) strips.push_back(std::move(strip));
  }
  std::stable_sort(strips.begin(), strips.end(),
                   [](const Strip& a, const Strip& b) { return a.sum > b.sum; });
  return strips;
}

void drop_corner_fans(Strip& strip, const Points& points, double near) {
  constexpr std::size_t fewest = 4;  // edges that remain
  const auto both = [&](bool front) {
    const DirectedEdge end = front ? strip.edges.front() : strip.edges.back();
    return std::max(fan_length(strip.edges, end[0], front), fan_length(strip.edges, end[1], front));
  };
  const std::size_t n = strip.edges.size();
  if (n < fewest || both(true) + both(false) + 2 > n) return;
  const SlitLine line = line_through(strip.edges, points, both(true), n - both(false));
  const std::size_t first = corner_fan(strip, points, line, near, true);
  const std::size_t last = corner_fan(strip, points, line, near, false);
  if (first + last + fewest > n) return;
  const auto crop = [&](auto& list) {
    list.erase(list.end() - static_cast<std::ptrdiff_t>(last), list.end());
    list.erase(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(first));
  };
  crop(strip.edges);
  crop(strip.strengths);
  strip.sum = std::accumulate(strip.strengths.begin(), strip.strengths.end(), 0.0);
}

void cut_strip(EditMesh& mesh, const Strip& strip) {
  for (const auto& [a, b] : strip.edges) {
    if (mesh.has_halfedge(a, b)) mesh.remove_face(a, b);
    if (mesh.has_halfedge(b, a)) mesh.remove_face(b, a);
  }
}

std::vector<VertexIndex> fill_notches(EditMesh& mesh, const Points& points, const Strip& strip,
                                      double largest) {
  std::vector<VertexIndex> loop = loop_through(mesh, strip.edges.front()[0]);
  const std::map<VertexIndex, int> side = sides_of(strip);
  const auto side_at = [&](VertexIndex v) {
    const auto found = side.find(v);
    return found == side.end() ? 0 : found->second;  // corners belong to both sides
  };
  while (loop.size() > 4) {
    double least = largest * std::numbers::pi / 180;
    std::size_t notch = loop.size();
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const VertexIndex a = loop[(i + loop.size() - 1) % loop.size()];
      const VertexIndex b = loop[i];
      const VertexIndex c = loop[(i + 1) % loop.size()];
      const bool one_side = side_at(b) != 0 && side_at(a) * side_at(b) >= 0 &&
                            side_at(c) * side_at(b) >= 0 && side_at(a) + side_at(c) != 0;
      if (!one_side || mesh.has_edge(a, c)) continue;
      const double angle = hole_angle(mesh, points, a, b, c);
      if (angle < least) {
        least = angle;
        notch = i;
      }
    }
    if (notch == loop.size()) return loop;
    const VertexIndex a = loop[(notch + loop.size() - 1) % loop.size()];
    mesh.add_face(loop[(notch + 1) % loop.size()], loop[notch], a);
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(notch));
  }
  return loop;
}

}  // namespace kinemesh
