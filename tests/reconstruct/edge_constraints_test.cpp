#include "reconstruct/edge_constraints.h"

#include <gtest/gtest.h>

#include "config/error.h"
#include "reconstruct/triangulate.h"
#include "tests/reconstruct/cloud.h"

namespace kinemesh::edge_constraints_test {
namespace {

using test::make_take;

/// A strip of quads, split the same way: 0 1 2 3 below, 4 5 6 7 above.
const Points ladder{{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 0, 0},
                    {0, 9, 0}, {10, 9, 0}, {20, 9, 0}, {30, 9, 0}};
EditMesh ladder_mesh() {
  return EditMesh(8, {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}});
}

TEST(EdgeConstraints, AnEdgeIsForcedAcrossSeveralOthers) {
  EditMesh mesh = ladder_mesh();
  EXPECT_TRUE(force_edge(mesh, ladder, 4, 2));
  EXPECT_TRUE(mesh.has_edge(4, 2));
  EXPECT_EQ(mesh.face_count(), 6U);
  EXPECT_EQ(mesh.euler_characteristic(), 1);
  EXPECT_TRUE(force_edge(mesh, ladder, 4, 2));             // it is there already
  EXPECT_FALSE(force_edge(mesh, ladder, 0, 6, {{2, 4}}));  // would cross the one to keep
  EXPECT_TRUE(mesh.has_edge(4, 2));
}

TEST(EdgeConstraints, AnEdgeIsRemovedByAFlipOrAtTheRim) {
  EditMesh mesh = ladder_mesh();
  EXPECT_TRUE(remove_edge(mesh, 1, 6));
  EXPECT_FALSE(mesh.has_edge(1, 6));
  EXPECT_TRUE(mesh.has_edge(2, 5));
  EXPECT_FALSE(remove_edge(mesh, 0, 4));  // its face is an ear: vertex 4 or 0 would be pinched
  EXPECT_TRUE(mesh.has_edge(0, 4));
  EXPECT_TRUE(remove_edge(mesh, 0, 7));  // not there
}

TEST(EdgeConstraints, HoldInTheTriangulation) {
  const MarkerSequence take = make_take({test::scatter(test::cap(80, 1.3), 12, 8)});
  const auto free = triangulate(take);
  // Force the other diagonal of an inner quadrilateral, and forbid one of another.
  const auto diagonal_of = [&](std::size_t skip) {
    for (const Edge& e : free.topology->edges()) {
      if (e.boundary() || skip-- > 0) continue;
      const auto c = free.topology->to(Topology::next(e.left));
      const auto d = free.topology->to(Topology::next(e.right));
      return std::array<VertexIndex, 4>{e.vertices[0], e.vertices[1], c, d};
    }
    return std::array<VertexIndex, 4>{};
  };
  const auto has = [](const Topology& t, VertexIndex a, VertexIndex b) {
    const auto ring = t.neighbours_of(a);
    return std::find(ring.begin(), ring.end(), b) != ring.end();
  };
  const auto name = [](VertexIndex a, VertexIndex b) {
    return "m" + std::to_string(a) + ":m" + std::to_string(b);
  };
  std::size_t forced = 0, removed = 0;
  for (std::size_t skip = 20; skip < 60; skip += 4) {
    const auto [a, b, c, d] = diagonal_of(skip);
    TriangulateOptions options;
    options.edges = {name(d, c)};
    try {
      const auto result = triangulate(take, options);
      EXPECT_TRUE(has(*result.topology, c, d));
      EXPECT_TRUE(result.topology->is_manifold());
      ++forced;
    } catch (const UsageError&) {
    }
    options = {};
    options.no_edges = {name(a, b)};
    try {
      const auto result = triangulate(take, options);
      EXPECT_FALSE(has(*result.topology, a, b));
      EXPECT_TRUE(result.topology->is_manifold());
      EXPECT_EQ(result.topology->isolated_vertex_count(), 0U);
      ++removed;
    } catch (const UsageError&) {
    }
  }
  EXPECT_GE(forced, 7U);  // a quadrilateral that is not convex has only one diagonal
  EXPECT_GE(removed, 7U);
}

TEST(EdgeConstraints, ImpossibleOnesAreRefusedWithTheMarkersNamed) {
  const MarkerSequence take = make_take({{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}});
  TriangulateOptions options;
  options.no_edges = {"m0:m1"};
  try {
    triangulate(take, options);
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("m0 and m1"), std::string::npos);
  }
}

}  // namespace
}  // namespace kinemesh::edge_constraints_test
