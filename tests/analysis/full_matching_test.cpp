#include "analysis/full_matching/full_matching.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <random>

#include "analysis/full_matching/smooth_deformation.h"
#include "analysis/spherical/closed_surface.h"
#include "analysis/spherical/sphere_locator.h"
#include "config/error.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/surface_map_io.h"
#include "tests/support/data.h"
#include "tests/support/ict_performer.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::full_matching_test {
namespace {

std::vector<Eigen::Vector3d> rest_of(const AnimatedMesh& mesh) {
  std::vector<Eigen::Vector3d> positions;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
    positions.push_back(mesh.position(0, v).cast<double>());
  return positions;
}

AnimatedMesh still(const test::Surface& surface) {
  AnimatedMesh mesh(surface.topology, 1, 0);
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
    mesh.position(0, v) = surface.positions[v].cast<float>();
  return mesh;
}

TEST(ClosedSurface, HolesAreFilledWithOrientedTrianglesOfBoundedAspect) {
  const test::Surface plate = test::plane_with_hole(24, 8, 16);
  const ClosedSurface closed = close_holes(*plate.topology, plate.positions);
  EXPECT_EQ(closed.loops.size(), 2U);
  EXPECT_TRUE(closed.topology->is_manifold());
  EXPECT_TRUE(closed.topology->boundary_loops().empty());
  EXPECT_EQ(closed.topology->euler_characteristic(), 2);
  EXPECT_EQ(closed.surface_faces, plate.topology->face_count());
  for (FaceIndex f = 0; f < closed.surface_faces; ++f)
    EXPECT_EQ(closed.topology->faces()[f], plate.topology->faces()[f]);
  for (FaceIndex f = 0; f < closed.topology->face_count(); ++f) {
    if (!closed.filling_face(f)) continue;
    const auto& [a, b, c] = closed.topology->faces()[f];
    const auto& p = closed.positions;
    const double longest =
        std::max({(p[a] - p[b]).norm(), (p[b] - p[c]).norm(), (p[c] - p[a]).norm()});
    EXPECT_GT((p[b] - p[a]).cross(p[c] - p[a]).norm(), 0.05 * longest * longest) << f;
  }
}

TEST(ClosedSurface, SurfacesWithHandlesAreRefused) {
  const test::Surface ring = test::torus(12, 8, 30, 10, 0, 1);
  EXPECT_THROW(close_holes(*ring.topology, ring.positions), NoResultError);
}

TEST(SphereLocator, FindsThePointOfEveryDirection) {
  const test::Surface ball = test::sphere(4, 1);
  const SphereLocator locator(*ball.topology, ball.positions);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector3d p =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    const SurfacePoint point = locator.locate(p, k % 3 == 0 ? FaceIndex{0} : invalid_index);
    const Eigen::Vector3d found = position_of(point, *ball.topology, ball.positions);
    EXPECT_LT((found.normalized() - p).norm(), 1e-12);
  }
  for (VertexIndex v = 0; v < ball.positions.size(); ++v) {
    const SurfacePoint point = locator.locate(ball.positions[v]);
    EXPECT_LT((position_of(point, *ball.topology, ball.positions) - ball.positions[v]).norm(),
              1e-12);
  }
}

class FacePair : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!std::filesystem::exists(test::data_folder() / "face_ict/meta.json")) return;
    const test::IctModel& model = test::ict_model();
    const test::IctMotion motion = test::make_ict_motion(model, 101, 1);
    a = test::perform(model, {.seed = 3}, motion, {.rate_hz = 20});
    b = test::perform(model, {.seed = 4}, motion, {.rate_hz = 20, .remesh_vertices = 4000});
    truth = test::true_map(model, a, b);
    matching = match_surfaces(a.mesh, b.mesh);
  }
  /// Each direction is the inverse of the other, also within triangles.
  static void expect_inverse() {
    const SurfaceOverlay& overlay = *matching.overlay;
    const auto own = rest_of(a.mesh);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    std::size_t whole = 0;
    for (std::size_t k = 0; k < 2000; ++k) {
      const auto f = static_cast<FaceIndex>(random() % a.mesh.topology().face_count());
      double u = unit(random), w = unit(random);
      if (u + w > 1) u = 1 - u, w = 1 - w;
      const SurfacePoint start{f, {1 - u - w, u, w}};
      const SurfacePoint end = overlay.to_source(overlay.to_target(start));
      if (!end.valid()) continue;
      ++whole;
      EXPECT_LT(
          (position_of(end, a.mesh.topology(), own) - position_of(start, a.mesh.topology(), own))
              .norm(),
          1e-3)
          << f;  // mm
    }
    EXPECT_GT(whole, 1900U);
    EXPECT_LT(matching.exactly.mean, 1e-6);
    EXPECT_LT(matching.exactly.worst, 1e-3);
    EXPECT_GT(matching.exactly.points, 4 * a.mesh.topology().face_count());
    // Samples at the vertices, read as linear, are coarser.
    EXPECT_LT(matching.by_vertices.mean, 3e-3);
    EXPECT_GT(matching.by_vertices.mean, matching.exactly.mean);
    // Vertices that are not moved to the edge of a hole are where the overlay leads them.
    for (VertexIndex v = 0; v < a.mesh.vertex_count(); v += 100) {
      const SurfacePoint there = overlay.to_target(vertex_point(a.mesh.topology(), v));
      if (!there.valid()) continue;
      EXPECT_EQ(there.face, matching.forward.points[v].face);
    }
  }

  inline static test::Performance a, b;
  inline static SurfaceMap truth;
  inline static FullMatching matching;
};

TEST_F(FacePair, VerticesAreMappedNearTheirTruePlacesAndExactlyBack) {
  KINEMESH_NEED_DATA("face_ict/meta.json");
  ASSERT_EQ(matching.forward.points.size(), a.mesh.vertex_count());
  ASSERT_EQ(matching.reverse.points.size(), b.mesh.vertex_count());
  check_surface_map(matching.forward, a.mesh.topology(), b.mesh.topology());
  const auto positions = rest_of(b.mesh);
  double area = 0, sum = 0, count = 0;
  for (const Triangle& t : b.mesh.topology().faces())
    area += (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).norm() / 2;
  for (VertexIndex v = 0; v < truth.points.size(); ++v) {
    if (!truth.points[v].valid() || !matching.forward.points[v].valid()) continue;
    sum += (position_of(truth.points[v], b.mesh.topology(), positions) -
            position_of(matching.forward.points[v], b.mesh.topology(), positions))
               .norm();
    ++count;
  }
  EXPECT_GT(count, 0.97 * static_cast<double>(a.mesh.vertex_count()));
  EXPECT_LT(sum / count / std::sqrt(area), 0.012);
  EXPECT_FALSE(matching.poor) << matching.warning;
  EXPECT_GT(matching.agreement.strain, 0.9);
  EXPECT_LT(matching.mean_distortion, 1.5);
  expect_inverse();
}

TEST(SmoothDeformation, ACubicIsFoundAndDisorderSaysNothing) {
  const test::Surface ball = test::sphere(3, 1);
  std::vector<Eigen::Vector3d> led, disorder;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const Eigen::Vector3d& p : ball.positions) {
    led.emplace_back(p.x() + 0.1 * p.y() * p.z(), 2 * p.y() - 0.2 * p.x() * p.x() * p.z(),
                     1 - p.z());
    disorder.emplace_back(normal(random), normal(random), normal(random));
  }
  const std::vector<double> areas(ball.positions.size(), 0.1);
  full_matching::SmoothDeformation deformation;
  deformation.fit(ball.positions, led, areas);
  EXPECT_LT(deformation.unexplained(), 1e-6);
  for (std::size_t v = 0; v < led.size(); v += 10)
    EXPECT_LT((deformation(ball.positions[v]) - led[v]).norm(), 1e-3);
  deformation.fit(ball.positions, disorder, areas);
  EXPECT_GT(deformation.unexplained(), 0.8);
}

TEST(FullMatching, SurfacesThatAreNoSpheresAreNamed) {
  const AnimatedMesh ball = still(test::sphere(2, 10));
  const AnimatedMesh ring = still(test::torus(12, 8, 30, 10, 0, 1));
  try {
    match_surfaces(ball, ring);
    FAIL();
  } catch (const NoResultError& e) {
    EXPECT_NE(std::string(e.what()).find("target"), std::string::npos) << e.what();
    EXPECT_FALSE(e.details().remedy.empty());
  }
  EXPECT_THROW(match_surfaces(AnimatedMesh(ball.shared_topology(), 0, 0), ball), InputError);
}

TEST(FullMatching, StillSurfacesAreMatchedByTheirShape) {
  const test::Surface box = test::bumpy(test::cube(10, 50), 2, 20);
  test::Surface turned = box;
  const Eigen::AngleAxisd turn(1.0, Eigen::Vector3d(1, 1, 2).normalized());
  for (Eigen::Vector3d& p : turned.positions) p = turn * p * 3;
  const FullMatching m = match_surfaces(still(box), still(turned));
  EXPECT_EQ(m.agreement.strain, 0);
  EXPECT_GT(m.agreement.normals, 0.9);
  EXPECT_LT(m.mean_distortion, 1.2);
  EXPECT_EQ(m.unmapped_source, 0U);
}

}  // namespace
}  // namespace kinemesh::full_matching_test
