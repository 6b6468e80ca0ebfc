#include "mesh/topology.h"

#include <gtest/gtest.h>

#include "config/error.h"

namespace kinemesh::topology_test {
namespace {

std::vector<Triangle> tetrahedron() { return {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}; }

/// An open ring of n quads, two triangles each: an annulus.
std::vector<Triangle> annulus(uint32_t n) {
  std::vector<Triangle> faces;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = (i + 1) % n;
    faces.push_back({i, j, n + i});
    faces.push_back({j, n + j, n + i});
  }
  return faces;
}

TEST(Topology, ClosedTetrahedron) {
  const Topology t(4, tetrahedron());
  EXPECT_TRUE(t.is_manifold());
  EXPECT_EQ(t.edge_count(), 6U);
  EXPECT_EQ(t.euler_characteristic(), 2);
  EXPECT_EQ(t.component_count(), 1U);
  EXPECT_TRUE(t.boundary_loops().empty());
  for (HalfedgeIndex h = 0; h < 12; ++h) {
    ASSERT_NE(t.twin(h), invalid_index);
    EXPECT_EQ(t.twin(t.twin(h)), h);
    EXPECT_EQ(t.from(t.twin(h)), t.to(h));
    EXPECT_EQ(t.to(h), t.from(Topology::next(h)));
    EXPECT_EQ(Topology::previous(Topology::next(h)), h);
  }
  EXPECT_EQ(t.neighbours_of(0).size(), 3U);
  EXPECT_EQ(t.faces_of(3).size(), 3U);
}

TEST(Topology, AnnulusHasTwoLoops) {
  const Topology t(16, annulus(8));
  EXPECT_TRUE(t.is_manifold());
  EXPECT_EQ(t.euler_characteristic(), 0);
  ASSERT_EQ(t.boundary_loops().size(), 2U);
  EXPECT_EQ(t.boundary_loops()[0].size(), 8U);
  EXPECT_EQ(t.boundary_loops()[1].size(), 8U);
  EXPECT_TRUE(t.is_boundary_vertex(3));
}

TEST(Topology, TwoTrianglesTouchingAtAVertexAreNotManifold) {
  const Topology t(5, {{0, 1, 2}, {0, 3, 4}});
  EXPECT_FALSE(t.is_manifold());
  EXPECT_EQ(t.component_count(), 2U);
  EXPECT_EQ(t.boundary_loops().size(), 2U);
}

TEST(Topology, ThreeFacesAtAnEdgeAndOppositeOrientationAreNotManifold) {
  EXPECT_FALSE(Topology(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}).is_manifold());
  EXPECT_FALSE(Topology(4, {{0, 1, 2}, {0, 1, 3}}).is_manifold());
  EXPECT_TRUE(Topology(4, {{0, 1, 2}, {1, 0, 3}}).is_manifold());
}

TEST(Topology, IsolatedVerticesAreCountedApart) {
  const Topology t(6, {{0, 1, 2}});
  EXPECT_EQ(t.isolated_vertex_count(), 3U);
  EXPECT_EQ(t.euler_characteristic(), 1);
  EXPECT_EQ(Topology(0, {}).euler_characteristic(), 0);
}

TEST(Topology, WrongFacesAreNamed) {
  try {
    Topology(3, {{0, 1, 2}, {0, 1, 7}});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(), "face 1 (0-based): it refers to vertex 7, but there are only 3");
  }
  EXPECT_THROW(Topology(3, {{0, 1, 1}}), InputError);
}

}  // namespace
}  // namespace kinemesh::topology_test
