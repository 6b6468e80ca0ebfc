#include "analysis/spherical/spherical_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "config/error.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/data.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::spherical_map_test {
namespace {

using test::Surface;

/// A sphere of rings × sectors, each point moved by `shape`.
template <class Shape>
Surface globe(const std::string& name, int rings, int sectors, Shape&& shape) {
  Surface surface{.name = name};
  surface.positions.emplace_back(0, 0, 1);
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double t = std::numbers::pi * i / rings, f = 2 * std::numbers::pi * j / sectors;
      surface.positions.emplace_back(std::sin(t) * std::cos(f), std::sin(t) * std::sin(f),
                                     std::cos(t));
    }
  }
  surface.positions.emplace_back(0, 0, -1);
  const auto last = static_cast<VertexIndex>(surface.positions.size() - 1);
  const auto at = [&](int i, int j) {
    return i == 0       ? VertexIndex{0}
           : i == rings ? last
                        : static_cast<VertexIndex>(1 + (i - 1) * sectors + j % sectors);
  };
  std::vector<Triangle> faces;
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      if (i > 0) faces.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rings) faces.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  for (Eigen::Vector3d& p : surface.positions) p = shape(p);
  surface.topology = Topology::create(surface.positions.size(), std::move(faces));
  return surface;
}

/// Six limbs `length` times as long as the body's radius.
Surface star(int rings, double length) {
  return globe("star", rings, rings, [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    const double along = p.cwiseAbs().maxCoeff();
    return p * (1 + length * std::exp(-60 * (1 - along)));
  });
}

std::vector<Surface> stress_family() {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Surface> family{test::sphere(0, 10),
                              test::sphere(4, 10),
                              test::cube(12, 50),
                              test::with_slivers(test::sphere(3, 10), 0.005, 3),
                              test::bumpy(test::sphere(4, 10), 3, 4),
                              star(40, 10),
                              star(24, 100)};
  family.push_back(globe("long", 60, 30, [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x(), p.y(), 30 * p.z());
  }));
  family.push_back(globe("flat", 40, 40, [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x(), p.y(), 1e-3 * p.z());
  }));
  family.push_back(globe("needles", 4, 300, [](const Eigen::Vector3d& p) { return p; }));
  family.push_back(globe("rings", 300, 3, [](const Eigen::Vector3d& p) { return p; }));
  family.push_back(globe("uneven", 60, 60, [](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return {p.x(), p.y(), std::pow((1 + p.z()) / 2, 6)};
  }));
  family.push_back(globe("rough", 50, 50, [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return p * (1 + 0.3 * uniform(random));
  }));
  return family;
}

void expect_covers_once(const Topology& topology, const std::vector<Eigen::Vector3d>& points,
                        const std::string& name) {
  double total = 0;
  for (const Triangle& t : topology.faces()) {
    EXPECT_GT(orientation(points[t[0]], points[t[1]], points[t[2]]), 0) << name;
    total += solid_angle(points[t[0]], points[t[1]], points[t[2]]);
  }
  EXPECT_NEAR(total, 4 * std::numbers::pi, 1e-6) << name;
  for (const Eigen::Vector3d& p : points) EXPECT_NEAR(p.norm(), 1, 1e-12) << name;
}

TEST(SphericalMap, NeverFoldsOnTheStressFamily) {
  for (const Surface& surface : stress_family()) {
    const SphericalMap map = map_to_sphere(*surface.topology, surface.positions);
    expect_covers_once(*surface.topology, map.points, surface.name);
    EXPECT_TRUE(map.check.valid()) << surface.name;
    EXPECT_GE(map.distortion, 0.999) << surface.name;
  }
}

TEST(SphericalMap, TetrahedronIsTheSmallestSurface) {
  const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto topology = Topology::create(4, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
  expect_covers_once(*topology, map_to_sphere(*topology, points).points, "tetrahedron");
}

TEST(SphericalMap, SphereIsMappedToItselfAlmostWithoutDistortion) {
  const Surface ball = test::sphere(4, 25);
  const SphericalMap map = map_to_sphere(*ball.topology, ball.positions);
  EXPECT_LT(map.distortion, 1.01);
  double worst = 0;  // distances between neighbours, on the sphere of radius 25
  for (const Edge& e : ball.topology->edges()) {
    const auto [a, b] = e.vertices;
    const double before = (ball.positions[a] - ball.positions[b]).norm();
    worst = std::max(worst, std::abs(25 * (map.points[a] - map.points[b]).norm() / before - 1));
  }
  EXPECT_LT(worst, 0.15);
}

TEST(SphericalMap, CopiesThatAreMovedAndScaledGetTheSameDistortion) {
  const Surface ball = test::bumpy(test::sphere(3, 10), 2, 5);
  const Eigen::AngleAxisd turn(1.1, Eigen::Vector3d(1, 2, 3).normalized());
  std::vector<Eigen::Vector3d> moved;
  for (const Eigen::Vector3d& p : ball.positions)
    moved.push_back(turn * p * 1000 + Eigen::Vector3d(5, 6, 7));
  EXPECT_NEAR(map_to_sphere(*ball.topology, ball.positions).distortion,
              map_to_sphere(*ball.topology, moved).distortion, 0.01);
}

TEST(SphericalMap, ClosedAnimalsAreMappedWithoutFolds) {
  KINEMESH_NEED_DATA("tosca_cat/cat0.off");
  for (const char* name :
       {"tosca_cat/cat0.off", "tosca_cat/cat8.off", "changing_pent/mesh_0000.ply"}) {
    const Mesh mesh = read_mesh(builtin_mesh_formats(), test::data_folder() / name);
    std::vector<Eigen::Vector3d> positions;
    for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
    const SphericalMap map = map_to_sphere(*mesh.topology, positions);
    expect_covers_once(*mesh.topology, map.points, name);
    EXPECT_LT(map.distortion, 4) << name;
  }
}

void expect_refusal(const Surface& surface, const std::string& reason) {
  try {
    map_to_sphere(*surface.topology, surface.positions);
    FAIL() << surface.name << " was mapped";
  } catch (const NoResultError& e) {
    EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
    EXPECT_FALSE(e.details().remedy.empty());
  }
}

TEST(SphericalMap, RefusesWhatIsNoSphere) {
  expect_refusal(test::torus(20, 12, 30, 10, 0, 1), "1 handle");
  expect_refusal(test::double_ring(), "2 handles");
  expect_refusal(test::plane_grid(4, 0, 1), "1 hole");
  Surface two = test::sphere(1, 10);
  std::vector<Triangle> faces = two.topology->faces();
  const auto count = static_cast<VertexIndex>(two.positions.size());
  for (std::size_t f = 0, n = faces.size(); f < n; ++f) {
    faces.push_back({faces[f][0] + count, faces[f][1] + count, faces[f][2] + count});
  }
  for (VertexIndex v = 0; v < count; ++v)
    two.positions.push_back(two.positions[v] + Eigen::Vector3d(50, 0, 0));
  two.topology = Topology::create(2 * count, faces);
  expect_refusal(two, "2 separate pieces");
  Surface point = test::sphere(1, 10);
  for (Eigen::Vector3d& p : point.positions) p.setZero();
  expect_refusal(point, "no area");
}

TEST(SphericalMap, NamesTheVertexThatIsNotFinite) {
  Surface ball = test::sphere(1, 10);
  ball.positions[5].y() = std::nan("");
  try {
    map_to_sphere(*ball.topology, ball.positions);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("vertex 5"), std::string::npos);
  }
}

TEST(Orientation, IsExactWhereRoundingIsNot) {
  const double tiny = std::ldexp(1.0, -70);
  const Eigen::Vector3d a(1, 0, 0), b(0.5, 0.5, 0);
  EXPECT_EQ(orientation(a, b, {0.3, 0.7, 0}), 0);
  EXPECT_EQ(orientation(a, b, {0.3, 0.7, tiny}), 1);
  EXPECT_EQ(orientation(a, b, {0.3, 0.7, -tiny}), -1);
  const Eigen::Vector3d c(0.1, 0.2, 0.3);  // 3 c is rounded, c + c is not
  EXPECT_EQ(orientation(c, c * 2, {1, 5, 7}), 0);
  EXPECT_EQ(orientation(c, {0.2, 0.4, std::nextafter(0.6, 1)}, {1, 0, 0}), 1);
}

TEST(SphereCheck, SolidAngleFindsWhatDeterminantsDoNot) {
  // A vertex moved to its antipode turns nothing over that the signs of its triangles would show
  // in every case, but the sphere is no longer covered once.
  const Surface ball = test::sphere(2, 1);
  EXPECT_TRUE(check_sphere(*ball.topology, ball.positions).valid());
  std::vector<Eigen::Vector3d> points = ball.positions;
  points[20] = -points[20];
  EXPECT_FALSE(check_sphere(*ball.topology, points).valid());
  // Twice around: all triangles are counter-clockwise.
  const Surface twice = globe("twice", 8, 12, [](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    const double f = 2 * std::atan2(p.y(), p.x()), r = std::hypot(p.x(), p.y());
    return {r * std::cos(f), r * std::sin(f), p.z()};
  });
  const SphereCheck check = check_sphere(*twice.topology, twice.positions);
  EXPECT_EQ(check.folded, 0U);
  EXPECT_NEAR(check.solid_angle, 8 * std::numbers::pi, 1e-9);
  EXPECT_FALSE(check.valid());
}

}  // namespace
}  // namespace kinemesh::spherical_map_test
