// Triangles without area, non-manifold meshes, and hostile shapes: finite distances, no crash.
#include <gtest/gtest.h>

#include <cmath>

#include "config/error.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/intrinsic_lengths.h"
#include "tests/support/data.h"
#include "tests/support/random.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::geodesics_degenerate_test {
namespace {

using test::Random;
using test::Surface;

/// A plane in which faces were split at a vertex that lies exactly on one of their edges, and
/// some edges were collapsed to nothing.
Surface degenerate_plane() {
  Surface s = test::plane_grid(8, 0.0, 0);
  std::vector<Triangle> faces;
  for (std::size_t f = 0; f < s.topology->face_count(); ++f) {
    const Triangle t = s.topology->faces()[f];
    if (f % 5 != 0) {
      faces.push_back(t);
      continue;
    }
    const auto fresh = static_cast<VertexIndex>(s.positions.size());
    // On the edge (a cap), or on a corner (a needle of no length).
    s.positions.push_back(f % 10 == 0
                              ? Eigen::Vector3d(0.5 * (s.positions[t[0]] + s.positions[t[1]]))
                              : s.positions[t[2]]);
    faces.insert(faces.end(), {{t[0], t[1], fresh}, {t[1], t[2], fresh}, {t[2], t[0], fresh}});
  }
  s.topology = Topology::create(s.positions.size(), faces);
  return s;
}

TEST(GeodesicsDegenerate, DistancesOfThePlaneRemain) {
  const Surface s = degenerate_plane();
  const GeodesicSolver solver(s.topology, s.positions);
  const GeodesicField field = solver.solve(40);
  EXPECT_GT(field.diagnostics.degenerate_faces, 20U);
  for (VertexIndex v = 0; v < s.positions.size(); ++v) {
    const double straight = (s.positions[v] - s.positions[40]).norm();
    EXPECT_NEAR(field.distances[v], straight, 1e-5);
    EXPECT_NEAR(solver.path_to(field, v).length, field.distances[v], 1e-5);
  }
}

TEST(GeodesicsDegenerate, OnlyDegenerateTrianglesChange) {
  const Surface sound = test::with_slivers(test::bumpy(test::sphere(2, 10.0), 0.5, 6.0), 1e-6, 3);
  const IntrinsicLengths untouched = intrinsic_lengths(*sound.topology, sound.positions);
  EXPECT_EQ(untouched.degenerate_faces, 0U);
  EXPECT_EQ(untouched.largest_change, 0.0);
  const Surface s = degenerate_plane();
  const IntrinsicLengths mended = intrinsic_lengths(*s.topology, s.positions);
  EXPECT_LT(mended.largest_change, 1e-11);
  for (HalfedgeIndex h = 0; h < mended.lengths.size(); ++h) {
    const HalfedgeIndex one = Topology::next(h), other = Topology::previous(h);
    EXPECT_GT(mended.lengths[one] + mended.lengths[other], mended.lengths[h]);
    if (s.topology->twin(h) != invalid_index) {
      EXPECT_EQ(mended.lengths[h], mended.lengths[s.topology->twin(h)]);
    }
  }
}

TEST(GeodesicsDegenerate, EverythingAtOnePlaceIsRefused) {
  const Surface s = test::cube(1, 1.0);
  const std::vector<Eigen::Vector3d> same(s.positions.size(), Eigen::Vector3d(1, 2, 3));
  EXPECT_THROW(GeodesicSolver(s.topology, same), InputError);
}

TEST(GeodesicsDegenerate, OneVertexPulledFarAwayOrOntoAnother) {
  for (const double factor : {0.0, 1e-9, 1e6}) {
    Surface s = test::sphere(2, 10.0);
    s.positions[20] = factor == 1e6
                          ? Eigen::Vector3d(factor * s.positions[20])
                          : Eigen::Vector3d(s.positions[s.topology->neighbours_of(20)[0]] +
                                            factor * s.positions[20]);
    const GeodesicSolver solver(s.topology, s.positions);
    for (const VertexIndex source : {0U, 20U}) {
      const GeodesicField field = solver.solve(source);
      for (VertexIndex v = 0; v < s.positions.size(); ++v) {
        ASSERT_TRUE(std::isfinite(field.distances[v]));
        EXPECT_NEAR(solver.path_to(field, v).length, field.distances[v],
                    1e-6 * (1 + field.distances[v]));
      }
    }
  }
}

TEST(GeodesicsDegenerate, NonManifoldMeshesGiveFiniteDistances) {
  // Two spheres that share a vertex, and a fin of one face on an edge of the first.
  const Surface a = test::sphere(1, 5.0);
  std::vector<Eigen::Vector3d> positions = a.positions;
  std::vector<Triangle> faces = a.topology->faces();
  const auto offset = static_cast<VertexIndex>(positions.size());
  const auto other = [&](VertexIndex v) { return v == 0 ? 0 : v + offset; };
  for (const Eigen::Vector3d& p : a.positions) positions.push_back(2.0 * a.positions[0] - p);
  for (const Triangle& t : a.topology->faces()) {
    faces.push_back({other(t[0]), other(t[1]), other(t[2])});
  }
  positions.emplace_back(0, 0, 20);
  faces.push_back({faces[5][0], faces[5][1], static_cast<VertexIndex>(positions.size() - 1)});
  const GeodesicSolver solver(Topology::create(positions.size(), faces), positions);
  for (const GeodesicMethod method :
       {GeodesicMethod::exact, GeodesicMethod::dijkstra, GeodesicMethod::heat}) {
    GeodesicOptions options;
    options.method = method;
    const GeodesicField field = solver.solve(7, options);
    for (VertexIndex v = 0; v < positions.size(); ++v) {
      if (v == offset) continue;  // stands for the shared vertex, without faces
      EXPECT_TRUE(std::isfinite(field.distances[v])) << v;
      if (method == GeodesicMethod::exact) {
        EXPECT_NEAR(solver.path_to(field, v).length, field.distances[v], 1e-9);
      }
    }
  }
}

TEST(GeodesicsDegenerate, SoupOfRandomTrianglesDoesNotHang) {
  Random random(77);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<Eigen::Vector3d> positions;
    for (int v = 0; v < 60; ++v) positions.push_back(10.0 * random.normal3());
    std::vector<Triangle> faces;
    while (faces.size() < 200) {
      const Triangle t{static_cast<VertexIndex>(random.below(60)),
                       static_cast<VertexIndex>(random.below(60)),
                       static_cast<VertexIndex>(random.below(60))};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) faces.push_back(t);
    }
    const GeodesicSolver solver(Topology::create(60, faces), positions);
    const GeodesicField field = solver.solve(faces[0][0]);
    GeodesicOptions dijkstra;
    dijkstra.method = GeodesicMethod::dijkstra;
    const GeodesicField edges = solver.solve(faces[0][0], dijkstra);
    for (VertexIndex v = 0; v < 60; ++v) {
      EXPECT_LE(field.distances[v], edges.distances[v] * (1 + 1e-12));
    }
  }
}

TEST(GeodesicsDegenerate, ChangingPentIsFiniteEverywhere) {
  std::size_t degenerate = 0;
  for (const char* name : {"mesh_0000.ply", "mesh_0017.ply", "mesh_0030.ply", "mesh_0049.ply"}) {
    KINEMESH_NEED_DATA(std::filesystem::path("changing_pent") / name);
    const Mesh mesh =
        read_mesh(builtin_mesh_formats(), test::data_folder() / "changing_pent" / name);
    const GeodesicSolver solver(mesh);
    const GeodesicField field = solver.solve(0);
    degenerate += field.diagnostics.degenerate_faces;
    for (VertexIndex v = 0; v < mesh.positions.size(); ++v) {
      ASSERT_TRUE(std::isfinite(field.distances[v])) << v;
      const double straight = (mesh.positions[v] - mesh.positions[0]).cast<double>().norm();
      EXPECT_GE(field.distances[v], (1 - 1e-6) * straight);
    }
    for (VertexIndex v = 0; v < mesh.positions.size(); v += 13) {
      EXPECT_NEAR(solver.path_to(field, v).length, field.distances[v],
                  1e-9 * field.distances[v] + 1e-9);
    }
  }
  EXPECT_GT(degenerate, 500U);
}

}  // namespace
}  // namespace kinemesh::geodesics_degenerate_test
