#include "tests/support/geodesic_delaunay.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/support/surface_distance.h"

namespace kinemesh::test {

namespace {

struct SiteDistance {
  uint32_t site;
  double squared;
};
using VertexSites = std::vector<std::vector<SiteDistance>>;  // per vertex, ascending by site

/// A corner of a cell's polygon in one fine triangle. `neighbour` is the site on the other side
/// of the polygon's edge that starts here; the triangle's own sides have none.
struct Corner {
  std::array<double, 3> weights;
  uint32_t neighbour = invalid_index;
};

struct Candidate {
  uint32_t site;
  std::array<double, 3> squared;  // at the triangle's corners
};

double value(const Candidate& c, const std::array<double, 3>& w) {
  return c.squared[0] * w[0] + c.squared[1] * w[1] + c.squared[2] * w[2];
}

/// Cuts off what is nearer to `other` than to `own`.
void clip(std::vector<Corner>& polygon, const Candidate& own, const Candidate& other) {
  std::vector<Corner> kept;
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Corner &a = polygon[i], &b = polygon[(i + 1) % n];
    const double fa = value(own, a.weights) - value(other, a.weights);
    const double fb = value(own, b.weights) - value(other, b.weights);
    if (fa <= 0) kept.push_back(a);
    if ((fa <= 0) == (fb <= 0)) continue;
    const double t = fa / (fa - fb);
    Corner cut;
    for (int k = 0; k < 3; ++k) cut.weights[k] = a.weights[k] + t * (b.weights[k] - a.weights[k]);
    // Leaving: the bisector starts here. Coming back: the rest of the old edge does.
    cut.neighbour = fa <= 0 ? other.site : a.neighbour;
    kept.push_back(cut);
  }
  polygon = std::move(kept);
}

std::vector<Candidate> candidates_of(const Triangle& face, const VertexSites& near) {
  std::vector<Candidate> all;
  for (const SiteDistance& first : near[face[0]]) {
    Candidate c{first.site, {first.squared, 0, 0}};
    bool everywhere = true;
    for (int corner = 1; corner < 3 && everywhere; ++corner) {
      const auto& list = near[face[corner]];
      const auto found = std::lower_bound(list.begin(), list.end(), first.site,
                                          [](const auto& s, uint32_t id) { return s.site < id; });
      everywhere = found != list.end() && found->site == first.site;
      if (everywhere) c.squared[corner] = found->squared;
    }
    if (everywhere) all.push_back(c);
  }
  std::vector<Candidate> kept;
  for (const Candidate& c : all) {
    const bool dominated = std::any_of(all.begin(), all.end(), [&](const Candidate& o) {
      return o.squared[0] < c.squared[0] && o.squared[1] < c.squared[1] &&
             o.squared[2] < c.squared[2];
    });
    if (!dominated) kept.push_back(c);
  }
  return kept;
}

struct Dual {
  std::map<std::array<uint32_t, 2>, double> lengths;
  std::set<Triangle> triangles;  // smallest site first
};

Triangle rotated(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

void collect_cell(const Candidate& own, const std::vector<Corner>& polygon,
                  const std::array<Eigen::Vector3d, 3>& p, Dual& dual) {
  const auto place = [&](const Corner& c) -> Eigen::Vector3d {
    return c.weights[0] * p[0] + c.weights[1] * p[1] + c.weights[2] * p[2];
  };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner &corner = polygon[i], &next = polygon[(i + 1) % polygon.size()];
    if (corner.neighbour == invalid_index) continue;
    if (own.site < corner.neighbour) {
      dual.lengths[{own.site, corner.neighbour}] += (place(next) - place(corner)).norm();
    }
    if (next.neighbour != invalid_index && next.neighbour != corner.neighbour) {
      dual.triangles.insert(rotated({own.site, corner.neighbour, next.neighbour}));
    }
  }
}

Dual voronoi_dual(const TrueSurface& surface, const VertexSites& near) {
  Dual dual;
  for (const Triangle& face : surface.topology->faces()) {
    const std::vector<Candidate> candidates = candidates_of(face, near);
    if (candidates.size() < 2) continue;
    const std::array<Eigen::Vector3d, 3> p{surface.positions[face[0]], surface.positions[face[1]],
                                           surface.positions[face[2]]};
    for (const Candidate& own : candidates) {
      std::vector<Corner> polygon{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
      for (const Candidate& other : candidates) {
        if (other.site != own.site && !polygon.empty()) clip(polygon, own, other);
      }
      collect_cell(own, polygon, p, dual);
    }
  }
  return dual;
}

uint32_t owner_at(const VertexSites& near, VertexIndex a, VertexIndex b, double t) {
  uint32_t owner = invalid_index;
  double best = SurfaceDistance::unreached;
  for (const SiteDistance& s : near[a]) {
    for (const SiteDistance& other : near[b]) {
      if (other.site != s.site) continue;
      const double squared = (1 - t) * s.squared + t * other.squared;
      if (squared < best) {
        best = squared;
        owner = s.site;
      }
    }
  }
  return owner;
}

/// Sites whose cells touch the slit, around it: along the upper side, back along the lower.
std::vector<uint32_t> ring_around(const Slit& slit, const VertexSites& near) {
  std::vector<VertexIndex> loop(slit.lower.begin(), slit.lower.end());
  for (std::size_t k = slit.upper.size() - 1; k > 1; --k) loop.push_back(slit.upper[k - 1]);
  std::vector<uint32_t> ring;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    for (int part = 0; part < 16; ++part) {
      const uint32_t owner = owner_at(near, loop[k], loop[(k + 1) % loop.size()], part / 16.0);
      if (owner != invalid_index && (ring.empty() || ring.back() != owner)) ring.push_back(owner);
    }
  }
  while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
  return ring;
}

using SitePair = std::array<uint32_t, 2>;
SitePair pair_of(uint32_t a, uint32_t b) { return a < b ? SitePair{a, b} : SitePair{b, a}; }

/// Takes off triangles with an over-long outer edge whose opposite vertex is inside: that neither
/// pinches the rim nor orphans a vertex.
class RimTrimmer {
 public:
  RimTrimmer(const Dual& dual, const std::vector<Eigen::Vector3d>& sites,
             const std::vector<GeodesicDelaunay::Opening>& openings)
      : sites_(sites), triangles_(dual.triangles) {
    for (const auto& opening : openings) {
      for (std::size_t k = 0; k < opening.ring.size(); ++k) {
        inner_.insert(pair_of(opening.ring[k], opening.ring[(k + 1) % opening.ring.size()]));
      }
    }
  }

  void trim(double longest) {
    while (true) {
      count_edges();
      const Triangle* worst = nullptr;
      double worst_length = longest;
      for (const Triangle& t : triangles_) {
        for (int k = 0; k < 3; ++k) {
          const double length = (sites_[t[k]] - sites_[t[(k + 1) % 3]]).norm();
          if (length > worst_length && removable(t, k)) {
            worst = &t;
            worst_length = length;
          }
        }
      }
      if (worst == nullptr) return;
      triangles_.erase(Triangle(*worst));
    }
  }

  bool outer(uint32_t a, uint32_t b) const {
    const auto found = uses_.find(pair_of(a, b));
    return found != uses_.end() && found->second == 1 && !inner_.contains(pair_of(a, b));
  }
  bool used(uint32_t a, uint32_t b) const { return uses_.contains(pair_of(a, b)); }
  const std::set<Triangle>& triangles() const { return triangles_; }

 private:
  void count_edges() {
    uses_.clear();
    rim_vertices_.clear();
    for (const Triangle& t : triangles_) {
      for (int k = 0; k < 3; ++k) ++uses_[pair_of(t[k], t[(k + 1) % 3])];
    }
    for (const auto& [edge, count] : uses_) {
      if (count == 1) rim_vertices_.insert(edge.begin(), edge.end());
    }
  }
  bool removable(const Triangle& t, int k) const {
    const uint32_t a = t[k], b = t[(k + 1) % 3], opposite = t[(k + 2) % 3];
    return outer(a, b) && !rim_vertices_.contains(opposite);
  }

  const std::vector<Eigen::Vector3d>& sites_;
  std::set<Triangle> triangles_;
  std::set<SitePair> inner_;
  std::map<SitePair, int> uses_;
  std::set<uint32_t> rim_vertices_;
};

VertexSites distances_near(const TrueSurface& surface, std::span<const SurfacePoint> sites,
                           double radius) {
  VertexSites near(surface.positions.size());
  SurfaceDistance distance(surface);
  for (uint32_t s = 0; s < sites.size(); ++s) {
    for (const auto& [v, d] : distance.from(sites[s], radius)) near[v].push_back({s, d * d});
  }
  return near;
}

}  // namespace

std::vector<double> local_spacing(std::span<const Eigen::Vector3d> points) {
  std::vector<double> spacing;
  for (const Eigen::Vector3d& p : points) {
    std::vector<double> distances;
    for (const Eigen::Vector3d& q : points) distances.push_back((p - q).norm());
    std::sort(distances.begin(), distances.end());
    const std::size_t n = std::min<std::size_t>(6, distances.size());
    double sum = 0;
    for (std::size_t k = 1; k < n; ++k) sum += distances[k];
    spacing.push_back(n > 1 ? sum / static_cast<double>(n - 1) : 0);
  }
  return spacing;
}

double mean_spacing(std::span<const Eigen::Vector3d> points) {
  double sum = 0;
  for (const double s : local_spacing(points)) sum += s;
  return points.empty() ? 0 : sum / static_cast<double>(points.size());
}

const GeodesicDelaunay::DualEdge* GeodesicDelaunay::find(uint32_t a, uint32_t b) const {
  const SitePair pair = pair_of(a, b);
  const auto found =
      std::lower_bound(edges.begin(), edges.end(), pair,
                       [](const DualEdge& e, const SitePair& p) { return e.sites < p; });
  return found != edges.end() && found->sites == pair ? &*found : nullptr;
}

GeodesicDelaunay geodesic_delaunay(const TrueSurface& surface, std::span<const SurfacePoint> sites,
                                   const GeodesicDelaunayOptions& options) {
  GeodesicDelaunay result;
  result.surface = close_slits(surface, options.open);
  for (const SurfacePoint& s : sites) {
    result.sites.push_back(position_of(s, *result.surface.topology, surface.positions));
  }
  result.spacing = mean_spacing(result.sites);
  const VertexSites near = distances_near(result.surface, sites, options.radius * result.spacing);
  const Dual dual = voronoi_dual(result.surface, near);
  for (const Slit& slit : result.surface.slits) {
    result.openings.push_back({slit.name, ring_around(slit, near)});
  }
  RimTrimmer trimmer(dual, result.sites, result.openings);
  trimmer.trim(options.longest_rim_edge * result.spacing);
  result.all_triangles.assign(dual.triangles.begin(), dual.triangles.end());
  result.triangles.assign(trimmer.triangles().begin(), trimmer.triangles().end());
  for (const auto& [pair, length] : dual.lengths) {
    if (length <= 1e-9) continue;
    const bool rim = trimmer.outer(pair[0], pair[1]);
    const bool core =
        length >= options.core_length * result.spacing && !rim && trimmer.used(pair[0], pair[1]);
    result.edges.push_back({pair, length, core, rim});
  }
  return result;
}

}  // namespace kinemesh::test
