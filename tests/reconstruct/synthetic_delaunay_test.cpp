#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "tests/support/geodesic_delaunay.h"
#include "tests/support/random.h"
#include "tests/support/surface_distance.h"
#include "tests/support/synthetic_body.h"

namespace kinemesh::test::synthetic_delaunay_test {
namespace {

/// A square of `cells`² cells from 0 to `size`, with inner vertices shaken so that obtuse
/// triangles occur, optionally cut along y = size / 2 from a third to two thirds.
class FlatSquare {
 public:
  FlatSquare(int cells, double size, bool cut, uint64_t seed) : cells_(cells) {
    Random random(seed);
    const double step = size / cells;
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        const bool inner = i > 0 && j > 0 && i < cells && j < cells && 2 * j != cells;
        const double shake = inner ? 0.2 * step : 0;
        surface.positions.emplace_back(i * step + random.uniform(-shake, shake),
                                       j * step + random.uniform(-shake, shake), 0);
      }
    }
    below_.resize(surface.positions.size());
    for (VertexIndex v = 0; v < below_.size(); ++v) below_[v] = v;
    if (cut) add_slit();
    add_faces();
  }
  TrueSurface surface;

 private:
  VertexIndex at(int i, int j) const { return static_cast<VertexIndex>(j * (cells_ + 1) + i); }
  void add_slit() {
    Slit slit{"slit", {}, {}};
    for (int i = cells_ / 3; i <= 2 * cells_ / 3; ++i) {
      const VertexIndex v = at(i, cells_ / 2);
      if (i > cells_ / 3 && i < 2 * cells_ / 3) {
        below_[v] = static_cast<VertexIndex>(surface.positions.size());
        surface.positions.push_back(Eigen::Vector3d(surface.positions[v]));
      }
      slit.upper.push_back(v);
      slit.lower.push_back(below_[v]);
    }
    surface.slits.push_back(slit);
  }
  void add_faces() {
    std::vector<Triangle> faces;
    for (int j = 0; j < cells_; ++j) {
      for (int i = 0; i < cells_; ++i) {
        const VertexIndex a = at(i, j), b = at(i + 1, j);
        const VertexIndex c = below_[at(i + 1, j + 1)], d = below_[at(i, j + 1)];
        faces.push_back({a, b, c});
        faces.push_back({a, c, d});
      }
    }
    surface.topology = Topology::create(surface.positions.size(), faces);
    for (const Eigen::Vector3d& p : surface.positions) surface.domain.emplace_back(p.x(), p.y());
  }
  int cells_;
  std::vector<VertexIndex> below_;
};

std::vector<SurfacePoint> random_points(const TrueSurface& s, std::size_t count, uint64_t seed) {
  Random random(seed);
  std::vector<SurfacePoint> points;
  while (points.size() < count) {
    double a = random.uniform(), b = random.uniform();
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    const auto face = static_cast<FaceIndex>(random.below(s.topology->face_count()));
    points.push_back({face, {1 - a - b, a, b}});
  }
  return points;
}

Triangle smallest_first(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

/// Counter-clockwise triangles with an empty circumcircle, by the definition; in the plane, with
/// the centre inside the square [0, size]².
std::set<Triangle> planar_delaunay(const std::vector<Eigen::Vector3d>& p, double size) {
  std::set<Triangle> triangles;
  const auto consider = [&](uint32_t a, uint32_t b, uint32_t c) {
    const Eigen::Vector2d ab = (p[b] - p[a]).head<2>(), ac = (p[c] - p[a]).head<2>();
    const double twice = ab.x() * ac.y() - ab.y() * ac.x();
    const Eigen::Vector2d radius =
        Eigen::Vector2d(ac.y() * ab.squaredNorm() - ab.y() * ac.squaredNorm(),
                        ab.x() * ac.squaredNorm() - ac.x() * ab.squaredNorm()) /
        (2 * twice);
    const Eigen::Vector2d centre = radius + p[a].head<2>();
    if (centre.minCoeff() < 0 || centre.maxCoeff() > size) return;
    const bool empty = std::none_of(p.begin(), p.end(), [&](const Eigen::Vector3d& q) {
      return (q.head<2>() - centre).norm() < radius.norm() - 1e-9;
    });
    if (empty) triangles.insert(smallest_first(twice > 0 ? Triangle{a, b, c} : Triangle{a, c, b}));
  };
  const auto n = static_cast<uint32_t>(p.size());
  for (uint32_t a = 0; a < n; ++a) {
    for (uint32_t b = a + 1; b < n; ++b) {
      for (uint32_t c = b + 1; c < n; ++c) consider(a, b, c);
    }
  }
  return triangles;
}

TEST(SyntheticDelaunay, EqualsThePlanarOneOnAPlane) {
  const TrueSurface square = FlatSquare(40, 100, false, 5).surface;
  const auto points = random_points(square, 60, 17);
  GeodesicDelaunayOptions options;
  options.radius = 20;  // further than any empty circle here
  options.longest_rim_edge = 1e9;
  const GeodesicDelaunay g = geodesic_delaunay(square, points, options);
  EXPECT_EQ(std::set<Triangle>(g.triangles.begin(), g.triangles.end()),
            planar_delaunay(g.sites, 100));
}

TEST(SyntheticDelaunay, DistancesAreExactOnAPlane) {
  const TrueSurface square = FlatSquare(30, 90, false, 3).surface;
  SurfaceDistance distance(square);
  for (const SurfacePoint& source : random_points(square, 20, 4)) {
    const Eigen::Vector3d p = position_of(source, *square.topology, square.positions);
    const auto reached = distance.from(source, 1000);
    EXPECT_EQ(reached.size(), square.positions.size());
    for (const auto& [v, d] : reached) EXPECT_NEAR(d, (square.positions[v] - p).norm(), 1e-6);
  }
}

TEST(SyntheticDelaunay, DistancesBendAroundASlit) {
  const TrueSurface square = FlatSquare(60, 90, true, 3).surface;  // slit from (30, 45) to (60, 45)
  SurfaceDistance distance(square);
  double worst = 0, squares = 0;
  std::size_t bent = 0, count = 0;
  for (const SurfacePoint& source : random_points(square, 60, 4)) {
    const Eigen::Vector3d p = position_of(source, *square.topology, square.positions);
    for (const auto& [v, d] : distance.from(source, 60)) {
      const Eigen::Vector3d q = square.positions[v];
      if (q.y() == 45 || d > 25) continue;  // on the slit's line it may be either side
      const double x = p.x() + (q.x() - p.x()) * (45 - p.y()) / (q.y() - p.y());
      double expected = (q - p).norm();
      if ((q.y() > 45) != (p.y() > 45) && x > 30 && x < 60) {
        const double left = std::hypot(p.x() - 30, p.y() - 45) + std::hypot(q.x() - 30, q.y() - 45);
        const double right =
            std::hypot(p.x() - 60, p.y() - 45) + std::hypot(q.x() - 60, q.y() - 45);
        expected = std::min(left, right);
        ++bent;
      }
      worst = std::max(worst, std::abs(d - expected));
      squares += (d - expected) * (d - expected);
      ++count;
    }
  }
  EXPECT_GT(bent, 500U);
  EXPECT_LT(worst, 0.15);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.005);
}

TEST(SyntheticDelaunay, NoEdgeCrossesASlitThatCounts) {
  const TrueSurface square = FlatSquare(60, 100, true, 8).surface;
  const auto points = random_points(square, 120, 2);
  const auto crossing = [](const GeodesicDelaunay& g) {
    std::size_t count = 0;
    for (const auto& e : g.edges) {
      const Eigen::Vector3d &a = g.sites[e.sites[0]], &b = g.sites[e.sites[1]];
      if ((a.y() > 50) == (b.y() > 50)) continue;
      const double x = a.x() + (b.x() - a.x()) * (50 - a.y()) / (b.y() - a.y());
      count += x > 38 && x < 62 ? 1 : 0;
    }
    return count;
  };
  const GeodesicDelaunay open = geodesic_delaunay(square, points, {.open = {"slit"}});
  const GeodesicDelaunay closed = geodesic_delaunay(square, points, {});
  EXPECT_EQ(crossing(open), 0U);
  EXPECT_GE(crossing(closed), 3U);
  EXPECT_TRUE(closed.openings.empty());
  ASSERT_EQ(open.openings.size(), 1U);
  const auto& ring = open.openings[0].ring;
  EXPECT_GE(ring.size(), 6U);
  for (std::size_t k = 0; k < ring.size(); ++k) {
    EXPECT_NE(open.find(ring[k], ring[(k + 1) % ring.size()]), nullptr);
  }
}

/// Edges of the convex hull, by the definition.
std::set<std::array<uint32_t, 2>> hull_edges(const std::vector<Eigen::Vector3d>& p) {
  std::set<std::array<uint32_t, 2>> hull;
  const auto n = static_cast<uint32_t>(p.size());
  const auto empty_above = [&](uint32_t a, uint32_t b, uint32_t c) {
    const Eigen::Vector3d normal = (p[b] - p[a]).cross(p[c] - p[a]);
    return std::none_of(p.begin(), p.end(),
                        [&](const Eigen::Vector3d& q) { return normal.dot(q - p[a]) > 1e-12; });
  };
  for (uint32_t a = 0; a < n; ++a) {
    for (uint32_t b = a + 1; b < n; ++b) {
      for (uint32_t c = 0; c < n; ++c) {
        if (c != a && c != b && empty_above(a, b, c)) hull.insert({a, b});
      }
    }
  }
  return hull;
}

/// On a sphere the Delaunay triangulation of points is their convex hull.
TEST(SyntheticDelaunay, EqualsTheConvexHullOnASphere) {
  const TrueSurface sphere = make_sphere(60);
  GeodesicDelaunayOptions options;
  options.radius = 5;
  options.longest_rim_edge = 1e9;
  const GeodesicDelaunay g = geodesic_delaunay(sphere, random_points(sphere, 80, 21), options);
  std::vector<Eigen::Vector3d> p;
  for (const Eigen::Vector3d& s : g.sites) p.push_back(s.normalized());
  const auto hull = hull_edges(p);
  ASSERT_EQ(hull.size(), 3 * 80U - 6);
  std::size_t wrong = 0, core = 0, found = 0;
  for (const auto& e : g.edges) {
    core += e.core ? 1 : 0;
    wrong += e.core && !hull.contains(e.sites) ? 1 : 0;
    found += hull.contains(e.sites) ? 1 : 0;
  }
  // Distances on the fine mesh are off by its sagitta, so edges whose Voronoi edge is next to
  // nothing may differ; core edges may not.
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(core, 200U);
  EXPECT_GE(found, hull.size() - 1);
  const Topology mesh(g.sites.size(), g.triangles);
  EXPECT_TRUE(mesh.is_manifold());
  EXPECT_EQ(mesh.euler_characteristic(), 2);
}

}  // namespace
}  // namespace kinemesh::test::synthetic_delaunay_test
