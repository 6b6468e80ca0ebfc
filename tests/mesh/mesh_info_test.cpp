#include "mesh/mesh_info.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random_animation.h"

namespace kinemesh::mesh_info_test {
namespace {

AnimatedMesh with_faces(std::size_t vertices, std::vector<Triangle> faces, std::size_t frames = 1) {
  AnimatedMesh mesh(Topology::create(vertices, std::move(faces)), frames, 50.0);
  for (std::size_t f = 0; f < frames; ++f) {
    for (VertexIndex v = 0; v < vertices; ++v) {
      mesh.position(f, v) = Eigen::Vector3f(std::cos(2.0F * v), std::sin(2.0F * v), 0.3F * v);
    }
  }
  return mesh;
}

/// A torus of n × m quads.
std::vector<Triangle> torus(uint32_t n, uint32_t m) {
  std::vector<Triangle> faces;
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = 0; j < m; ++j) {
      const uint32_t a = i * m + j, b = i * m + (j + 1) % m;
      const uint32_t c = (i + 1) % n * m + j, d = (i + 1) % n * m + (j + 1) % m;
      faces.push_back({a, c, b});
      faces.push_back({b, c, d});
    }
  }
  return faces;
}

TEST(MeshInfo, GenusOfKnownSurfaces) {
  const MeshInfo ball = mesh_info_of(with_faces(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
  EXPECT_EQ(ball.genus, 0);
  EXPECT_TRUE(ball.boundaries.empty());
  const MeshInfo ring = mesh_info_of(with_faces(30, torus(5, 6)));
  EXPECT_EQ(ring.genus, 1);
  EXPECT_EQ(ring.euler_characteristic, 0);
  std::vector<Triangle> opened = torus(5, 6);
  opened.pop_back();
  const MeshInfo open = mesh_info_of(with_faces(31, opened));
  EXPECT_EQ(open.genus, 1);
  EXPECT_EQ(open.boundaries, std::vector<std::size_t>{3});
  EXPECT_EQ(open.isolated_vertices, 1U);
  EXPECT_FALSE(mesh_info_of(with_faces(4, {{0, 1, 2}, {0, 1, 3}})).genus.has_value());
}

TEST(MeshInfo, TimingExtentAndFilled) {
  AnimatedMesh mesh = test::smooth_animation(5, 4, 10, 20.0);
  mesh.position(7, 3).x() = 500.0F;
  mesh.add_filled();
  mesh.filled()[5] = 1;
  mesh.first_frame = 31;
  const MeshInfo info = mesh_info_of(mesh);
  EXPECT_EQ(info.frames, 10U);
  EXPECT_DOUBLE_EQ(info.duration_s, 0.5);
  EXPECT_EQ(info.first_frame, 31);
  EXPECT_EQ(info.high.x(), 500.0F);
  EXPECT_EQ(info.filled_samples, 1U);
  EXPECT_EQ(info.samples, 200U);
  EXPECT_EQ(info.boundaries, std::vector<std::size_t>{14});
  EXPECT_EQ(info.genus, 0);
  EXPECT_NEAR(info.mean_edge_mm, 11.5, 1.0);
}

TEST(MeshInfo, WorstTriangleIsFoundInItsFrame) {
  AnimatedMesh mesh = test::smooth_animation(6, 6, 12, 20.0);
  const Triangle t = mesh.topology().faces()[17];
  mesh.position(9, t[2]) = 0.5F * (mesh.position(9, t[0]) + mesh.position(9, t[1]));
  const MeshInfo info = mesh_info_of(mesh, 3);
  ASSERT_EQ(info.worst.size(), 3U);
  EXPECT_EQ(info.worst[0].face, 17U);
  EXPECT_EQ(info.worst[0].frame, 9U);
  EXPECT_LT(info.worst[0].smallest_angle_deg, 0.01);
  EXPECT_LE(info.worst[0].smallest_angle_deg, info.worst[1].smallest_angle_deg);
}

TEST(MeshInfo, ShapesOfKnownTriangles) {
  const Eigen::Vector3d a(0, 0, 0), b(1, 0, 0);
  const TriangleShape even = shape_of(a, b, {0.5, std::sqrt(0.75), 0});
  EXPECT_NEAR(even.smallest_angle_deg, 60.0, 1e-9);
  EXPECT_NEAR(even.aspect, 1.0, 1e-9);
  const TriangleShape right = shape_of(a, b, {0, 1, 0});
  EXPECT_NEAR(right.smallest_angle_deg, 45.0, 1e-9);
  EXPECT_NEAR(right.aspect, std::sqrt(0.5) / (2 - std::sqrt(2.0)), 1e-9);
  EXPECT_NEAR(shape_of(a, b, {0.5, 1e-6, 0}).smallest_angle_deg, 2e-6 * 57.29577951, 1e-10);
  EXPECT_TRUE(std::isinf(shape_of(a, b, {2, 0, 0}).aspect));
  EXPECT_EQ(shape_of(a, a, b).smallest_angle_deg, 0.0);
}

}  // namespace
}  // namespace kinemesh::mesh_info_test
