#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "mesh/geodesics/geodesics.h"
#include "tests/support/random.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::geodesics_exact_test {
namespace {

using test::Random;
using test::Surface;

GeodesicSolver solver_for(const Surface& s) { return {s.topology, s.positions}; }

SurfacePoint random_point(const Surface& s, Random& random) {
  SurfacePoint point;
  point.face = static_cast<FaceIndex>(random.below(s.topology->face_count()));
  const double u = std::sqrt(random.uniform()), v = random.uniform();
  point.weights = {1 - u, u * (1 - v), u * v};
  return point;
}

Eigen::Vector3d place(const Surface& s, const SurfacePoint& p) {
  return position_of(p, *s.topology, s.positions);
}

std::vector<Surface> family() {
  return {test::plane_grid(9, 0.3, 1),
          test::plane_with_hole(9, 3, 6),
          test::cube(4, 10.0),
          test::sphere(3, 10.0),
          test::torus(24, 12, 10.0, 4.0, 0.2, 2),
          test::double_ring(),
          test::bumpy(test::sphere(3, 10.0), 0.8, 5.0),
          test::bumpy(test::plane_grid(15, 0.2, 3), 0.7, 5.0),
          test::with_slivers(test::bumpy(test::cube(3, 10.0), 0.5, 6.0), 1e-5, 4),
          test::with_slivers(test::plane_grid(6, 0.2, 5), 1e-4, 5)};
}

TEST(GeodesicsExact, InThePlaneTheyAreStraight) {
  for (const Surface& s : {test::plane_grid(12, 0.35, 7), test::plane_grid(10, 0.0, 0),
                           test::with_slivers(test::plane_grid(8, 0.3, 8), 1e-6, 8)}) {
    const GeodesicSolver solver = solver_for(s);
    Random random(3);
    for (int trial = 0; trial < 10; ++trial) {
      const SurfacePoint source = random_point(s, random);
      const std::vector<SurfacePoint> targets{random_point(s, random), random_point(s, random),
                                              source};
      const GeodesicField field = solver.solve({source}, {}, {}, targets);
      for (VertexIndex v = 0; v < s.positions.size(); ++v) {
        EXPECT_NEAR(field.distances[v], (s.positions[v] - place(s, source)).norm(), 1e-10);
      }
      for (std::size_t t = 0; t < targets.size(); ++t) {
        const double straight = (place(s, targets[t]) - place(s, source)).norm();
        EXPECT_NEAR(field.target_distances[t], straight, 1e-10);
        EXPECT_NEAR(solver.path_to_target(field, t).length, straight, 1e-9);
      }
    }
  }
}

TEST(GeodesicsExact, AroundAHoleTheyBendAtItsCorners) {
  const Surface s = test::plane_with_hole(9, 3, 6);
  const auto vertex = [&](int column, int row) {
    const auto found =
        std::find(s.positions.begin(), s.positions.end(), Eigen::Vector3d(column, row, 0));
    return static_cast<VertexIndex>(found - s.positions.begin());
  };
  const GeodesicSolver solver = solver_for(s);
  const GeodesicField field = solver.solve(vertex(4, 0));
  // (4, 0) → the corner (3, 3) → (4, 9): left around; right around over (6, 3) and (6, 6) is
  // longer.
  const double left = std::hypot(1, 3) + 3.0 + std::hypot(1, 3);
  EXPECT_NEAR(field.distances[vertex(4, 9)], left, 1e-12);
  EXPECT_NEAR(field.distances[vertex(0, 9)], std::hypot(4, 9), 1e-12);  // passes the hole
  const GeodesicPath path = solver.path_to(field, vertex(4, 9));
  EXPECT_NEAR(path.length, left, 1e-12);
  EXPECT_EQ(place(s, path.points.front()), s.positions[vertex(4, 0)]);
  EXPECT_EQ(place(s, path.points.back()), s.positions[vertex(4, 9)]);
}

TEST(GeodesicsExact, OnACubeTheyTakeTheBestUnfolding) {
  for (const int n : {1, 2, 5}) {
    const Surface s = test::cube(n, 10.0);
    VertexIndex low = invalid_index, high = invalid_index;
    for (VertexIndex v = 0; v < s.positions.size(); ++v) {
      if (s.positions[v].norm() == 0.0) low = v;
      if (s.positions[v].isApprox(Eigen::Vector3d(10, 10, 10))) high = v;
    }
    const GeodesicSolver solver = solver_for(s);
    const GeodesicField field = solver.solve(low);
    EXPECT_NEAR(field.distances[high], 10.0 * std::sqrt(5.0), 1e-12);
    EXPECT_NEAR(solver.path_to(field, high).length, 10.0 * std::sqrt(5.0), 1e-12);
  }
}

TEST(GeodesicsExact, OnASphereTheyApproachGreatCircles) {
  const Surface s = test::sphere(4, 10.0);
  const GeodesicField field = solver_for(s).solve(5);
  for (VertexIndex v = 0; v < s.positions.size(); ++v) {
    const double angle =
        std::atan2(s.positions[5].cross(s.positions[v]).norm(), s.positions[5].dot(s.positions[v]));
    EXPECT_NEAR(field.distances[v], 10.0 * angle, 0.004 * 10.0 * angle + 1e-9);
  }
}

TEST(GeodesicsExact, PathsAreAsLongAsTheDistanceSays) {
  for (const Surface& s : family()) {
    const GeodesicSolver solver = solver_for(s);
    Random random(11);
    for (const SurfacePoint& source : {vertex_point(*s.topology, 3), random_point(s, random)}) {
      std::vector<SurfacePoint> targets;
      for (int t = 0; t < 10; ++t) targets.push_back(random_point(s, random));
      const GeodesicField field = solver.solve({source}, {}, {}, targets);
      for (VertexIndex v = 0; v < s.positions.size(); v += 3) {
        const GeodesicPath path = solver.path_to(field, v);
        EXPECT_NEAR(path.length, field.distances[v], 1e-9 * (1 + field.distances[v])) << s.name;
        EXPECT_LT((place(s, path.points.front()) - place(s, source)).norm(), 1e-12);
        EXPECT_LT((place(s, path.points.back()) - s.positions[v]).norm(), 1e-12);
      }
      for (std::size_t t = 0; t < targets.size(); ++t) {
        EXPECT_NEAR(solver.path_to_target(field, t).length, field.target_distances[t],
                    1e-9 * (1 + field.target_distances[t]))
            << s.name;
      }
    }
  }
}

TEST(GeodesicsExact, DistancesAreAMetric) {
  for (const Surface& s : family()) {
    const GeodesicSolver solver = solver_for(s);
    Random random(5);
    std::vector<SurfacePoint> points;
    for (int i = 0; i < 6; ++i) points.push_back(random_point(s, random));
    points.push_back(vertex_point(*s.topology, 0));
    // A point on an edge.
    points.push_back({7, {0.25, 0.75, 0.0}});
    std::vector<std::vector<double>> d;
    for (const SurfacePoint& p : points)
      d.push_back(solver.solve({p}, {}, {}, points).target_distances);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(d[i][i], 0.0, 1e-12);
      for (std::size_t j = 0; j < points.size(); ++j) {
        EXPECT_NEAR(d[i][j], d[j][i], 1e-9 * (1 + d[i][j])) << s.name << " " << i << " " << j;
        EXPECT_GE(d[i][j], (place(s, points[i]) - place(s, points[j])).norm() - 1e-9);
        for (std::size_t k = 0; k < points.size(); ++k) {
          EXPECT_LE(d[i][j], d[i][k] + d[k][j] + 1e-9) << s.name;
        }
      }
    }
  }
}

TEST(GeodesicsExact, SeveralSourcesGiveTheNearest) {
  for (const Surface& s : family()) {
    const GeodesicSolver solver = solver_for(s);
    Random random(9);
    std::vector<SurfacePoint> sources{vertex_point(*s.topology, 1)};
    // Points of one face see each other's pencils pass over them.
    const FaceIndex shared = static_cast<FaceIndex>(random.below(s.topology->face_count()));
    sources.push_back({shared, {0.6, 0.2, 0.2}});
    sources.push_back({shared, {0.2, 0.3, 0.5}});
    for (int i = 0; i < 3; ++i) sources.push_back(random_point(s, random));
    const GeodesicField all = solver.solve(sources);
    std::vector<GeodesicField> single;
    for (const SurfacePoint& p : sources) single.push_back(solver.solve({p}));
    for (VertexIndex v = 0; v < s.positions.size(); ++v) {
      double best = unreachable;
      for (const GeodesicField& f : single) best = std::min(best, f.distances[v]);
      EXPECT_NEAR(all.distances[v], best, 1e-10 * (1 + best)) << s.name << " " << v;
      ASSERT_LT(all.nearest_source[v], sources.size());
      EXPECT_NEAR(single[all.nearest_source[v]].distances[v], best, 1e-10 * (1 + best)) << s.name;
    }
  }
}

TEST(GeodesicsExact, ARadiusCutsOffAndChangesNothingWithin) {
  for (const Surface& s : family()) {
    const GeodesicSolver solver = solver_for(s);
    const GeodesicField full = solver.solve(2);
    GeodesicOptions options;
    options.radius_mm = 4.0;
    const GeodesicField cut = solver.solve(2, options);
    std::size_t near = 0;
    for (VertexIndex v = 0; v < s.positions.size(); ++v) {
      near += full.distances[v] <= 4.0 ? 1 : 0;
      EXPECT_EQ(cut.distances[v], full.distances[v] <= 4.0 ? full.distances[v] : unreachable);
    }
    const auto within = solver.within(vertex_point(*s.topology, 2), 4.0);
    ASSERT_EQ(within.size(), near);
    for (std::size_t i = 0; i < within.size(); ++i) {
      EXPECT_EQ(within[i].second, full.distances[within[i].first]);
      EXPECT_GE(within[i].second, within[i > 0 ? i - 1 : 0].second);
    }
    // The workspace is used again: nothing of the search before may remain.
    EXPECT_EQ(solver.solve(2).distances, full.distances);
  }
}

TEST(GeodesicsExact, MovingScalingAndRenumberingChangeNothingElse) {
  for (const Surface& s : family()) {
    const GeodesicField field = solver_for(s).solve(4);
    Random random(21);
    std::vector<VertexIndex> new_index(s.positions.size());
    for (VertexIndex v = 0; v < new_index.size(); ++v) new_index[v] = v;
    random.shuffle(new_index);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    std::vector<Eigen::Vector3d> positions(s.positions.size());
    for (VertexIndex v = 0; v < new_index.size(); ++v) {
      positions[new_index[v]] = 250.0 * (turn * s.positions[v]) + Eigen::Vector3d(900, -40, 7);
    }
    std::vector<Triangle> faces;
    for (const Triangle& t : s.topology->faces()) {
      faces.push_back({new_index[t[1]], new_index[t[2]], new_index[t[0]]});
    }
    random.shuffle(faces);
    const GeodesicSolver moved(Topology::create(positions.size(), faces), positions);
    const GeodesicField again = moved.solve(new_index[4]);
    for (VertexIndex v = 0; v < new_index.size(); ++v) {
      EXPECT_NEAR(again.distances[new_index[v]], 250.0 * field.distances[v],
                  1e-8 * 250.0 * (1e-3 + field.distances[v]))
          << s.name;
    }
  }
}

TEST(GeodesicsExact, PiecesThatDoNotHangTogetherAreUnreachable) {
  const Surface a = test::cube(2, 5.0), b = test::sphere(1, 3.0);
  std::vector<Eigen::Vector3d> positions = a.positions;
  std::vector<Triangle> faces = a.topology->faces();
  const auto offset = static_cast<VertexIndex>(positions.size());
  positions.insert(positions.end(), b.positions.begin(), b.positions.end());
  for (const Triangle& t : b.topology->faces()) {
    faces.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  positions.emplace_back(0, 0, 100);  // a vertex without faces
  const GeodesicSolver solver(Topology::create(positions.size(), faces), positions);
  for (const GeodesicMethod method :
       {GeodesicMethod::exact, GeodesicMethod::dijkstra, GeodesicMethod::heat}) {
    GeodesicOptions options;
    options.method = method;
    const GeodesicField field = solver.solve(0, options);
    for (VertexIndex v = 0; v < positions.size(); ++v) {
      EXPECT_EQ(std::isfinite(field.distances[v]), v < offset);
    }
  }
  const GeodesicField field = solver.solve(0);
  EXPECT_THROW(solver.path_to(field, offset), NoResultError);
  EXPECT_THROW(solver.solve(static_cast<VertexIndex>(positions.size() - 1)), UsageError);
}

TEST(GeodesicsExact, WrongInputIsRefusedWithItsPlace) {
  const Surface s = test::cube(2, 5.0);
  const GeodesicSolver solver = solver_for(s);
  EXPECT_THROW(solver.solve(std::vector<SurfacePoint>{}), UsageError);
  EXPECT_THROW(solver.solve({SurfacePoint{}}), UsageError);
  EXPECT_THROW(solver.solve({SurfacePoint{0, {0.5, 0.6, 0.7}}}), UsageError);
  EXPECT_THROW(solver.solve({SurfacePoint{0, {std::nan(""), 0.5, 0.5}}}), UsageError);
  EXPECT_THROW(solver.solve(VertexIndex{100000}), UsageError);
  GeodesicOptions options;
  options.radius_mm = -1.0;
  EXPECT_THROW(solver.solve(0, options), UsageError);
  std::vector<Eigen::Vector3d> positions = s.positions;
  positions[3].y() = std::nan("");
  try {
    GeodesicSolver(s.topology, positions);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("vertex 3"), std::string::npos);
  }
  RunContext cancelled;
  cancelled.cancel();
  EXPECT_THROW(solver.solve(0, {}, cancelled), CancelledError);
  EXPECT_EQ(solver.solve(0).distances.size(), s.positions.size());  // and it works on
}

}  // namespace
}  // namespace kinemesh::geodesics_exact_test
