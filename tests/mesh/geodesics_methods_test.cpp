// The heat method, the intrinsic Delaunay triangulation, Dijkstra, and all pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "config/error.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/npz.h"
#include "mesh/geodesics/all_pairs.h"
#include "mesh/geodesics/heat_method.h"
#include "mesh/geodesics/intrinsic_delaunay.h"
#include "mesh/geodesics/intrinsic_lengths.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::geodesics_methods_test {
namespace {

using test::Surface;

GeodesicField solve(const GeodesicSolver& solver, VertexIndex source, GeodesicMethod method) {
  GeodesicOptions options;
  options.method = method;
  return solver.solve(source, options);
}

double mean_error(const GeodesicField& field, const GeodesicField& exact) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < exact.distances.size(); ++v) {
    if (!(exact.distances[v] > 0.0)) continue;
    sum += std::abs(field.distances[v] - exact.distances[v]) / exact.distances[v];
    ++count;
  }
  return sum / static_cast<double>(count);
}

TEST(GeodesicsIntrinsicDelaunay, OppositeAnglesSumToAtMostPiAndAreaStays) {
  for (const Surface& s :
       {test::bumpy(test::torus(30, 10, 10.0, 4.0, 0.3, 4), 0.5, 6.0),
        test::with_slivers(test::sphere(2, 5.0), 1e-3, 2), test::plane_with_hole(7, 2, 4)}) {
    const IntrinsicTriangulation t = intrinsic_delaunay(*s.topology, s.positions);
    ASSERT_EQ(t.faces.size(), s.topology->face_count());
    double before = 0.0, after = 0.0;
    const IntrinsicLengths plain = intrinsic_lengths(*s.topology, s.positions);
    for (std::size_t f = 0; f < t.faces.size(); ++f) {
      const auto& [a, b, c] = t.lengths[f];
      after += double_area(a, b, c);
      before +=
          double_area(plain.lengths[3 * f], plain.lengths[3 * f + 1], plain.lengths[3 * f + 2]);
    }
    EXPECT_NEAR(after, before, 1e-7 * before) << s.name;
    // Sum of cotangents by edge, where the two vertices share one edge only.
    std::map<std::pair<VertexIndex, VertexIndex>, std::pair<int, double>> edges;
    for (std::size_t f = 0; f < t.faces.size(); ++f) {
      for (int e = 0; e < 3; ++e) {
        const double a = t.lengths[f][e], b = t.lengths[f][(e + 1) % 3],
                     c = t.lengths[f][(e + 2) % 3];
        const VertexIndex i = t.faces[f][e], j = t.faces[f][(e + 1) % 3];
        auto& [count, sum] = edges[std::minmax(i, j)];
        ++count;
        sum += (b * b + c * c - a * a) / (2.0 * double_area(a, b, c));
      }
    }
    for (const auto& [edge, value] : edges) {
      EXPECT_TRUE(value.first != 2 || value.second > -1e-5) << s.name;
    }
  }
}

TEST(GeodesicsHeat, OnASphereItComesCloseToGreatCircles) {
  const Surface s = test::sphere(4, 10.0);
  const GeodesicSolver solver(s.topology, s.positions);
  const GeodesicField exact = solver.solve(0);
  EXPECT_LT(mean_error(solve(solver, 0, GeodesicMethod::heat), exact), 0.02);
  const double between = mean_error(solve(solver, 0, GeodesicMethod::dijkstra), exact);
  EXPECT_LT(between, 0.12);
  EXPECT_GT(between, 0.01);
}

TEST(GeodesicsHeat, SliversDoNotSpoilIt) {
  const Surface s = test::with_slivers(test::bumpy(test::sphere(3, 10.0), 0.4, 8.0), 1e-3, 6);
  const GeodesicSolver solver(s.topology, s.positions);
  EXPECT_LT(mean_error(solve(solver, 3, GeodesicMethod::heat), solver.solve(3)), 0.06);
}

TEST(GeodesicsHeat, RealAnimalsWithinAFewPercent) {
  for (const char* name : {"tosca_cat/cat0.off", "tosca_cat/cat5.off", "anim/horse_gallop.ply"}) {
    KINEMESH_NEED_DATA(name);
    const GeodesicSolver solver(read_mesh(builtin_mesh_formats(), test::data_folder() / name));
    for (const VertexIndex source : {0U, 1666U, 4000U}) {
      EXPECT_LT(mean_error(solve(solver, source, GeodesicMethod::heat), solver.solve(source)), 0.04)
          << name;
    }
  }
}

TEST(GeodesicsHeat, PathsAreRefused) {
  const Surface s = test::cube(3, 9.0);
  const GeodesicSolver solver(s.topology, s.positions);
  EXPECT_THROW(solver.path_to(solve(solver, 0, GeodesicMethod::heat), 5), UsageError);
}

TEST(GeodesicsDijkstra, DistancesAndPathsRunAlongEdges) {
  const Surface s = test::plane_grid(6, 0.0, 0);
  const GeodesicSolver solver(s.topology, s.positions);
  const GeodesicField field = solve(solver, 0, GeodesicMethod::dijkstra);
  for (int row = 0; row <= 6; ++row) {
    for (int column = 0; column <= 6; ++column) {
      const int diagonal = std::min(row, column), straight = std::max(row, column) - diagonal;
      const VertexIndex v = row * 7 + column;
      EXPECT_NEAR(field.distances[v], diagonal * std::numbers::sqrt2 + straight, 1e-12);
      const GeodesicPath path = solver.path_to(field, v);
      EXPECT_NEAR(path.length, field.distances[v], 1e-12);
      for (const SurfacePoint& p : path.points) {
        EXPECT_EQ(*std::max_element(p.weights.begin(), p.weights.end()), 1.0);
      }
    }
  }
}

TEST(GeodesicsAllPairs, RowsAreSingleSearchesForAnyNumberOfThreads) {
  const Surface s = test::bumpy(test::torus(16, 8, 10.0, 4.0, 0.2, 1), 0.5, 6.0);
  const GeodesicSolver solver(s.topology, s.positions);
  const std::vector<SurfacePoint> sources = all_vertex_points(*s.topology);
  RunContext one, several;
  one.set_threads(1);
  several.set_threads(3);
  const DistanceMatrix matrix = distance_matrix(solver, sources, one);
  EXPECT_EQ(matrix, distance_matrix(solver, sources, several));
  EXPECT_LT((matrix - matrix.transpose()).cwiseAbs().maxCoeff(), 1e-4F);
  const GeodesicField row = solver.solve(7);
  for (std::size_t v = 0; v < s.positions.size(); ++v) {
    EXPECT_EQ(matrix(7, static_cast<Eigen::Index>(v)), static_cast<float>(row.distances[v]));
  }
  std::size_t seen = 0;
  for_each_distance_row(
      solver, sources,
      [&](std::size_t first, const auto& rows) {
        EXPECT_EQ(first, seen);
        EXPECT_EQ(rows, matrix.middleRows(static_cast<Eigen::Index>(first), rows.rows()));
        seen += static_cast<std::size_t>(rows.rows());
      },
      50);
  EXPECT_EQ(seen, sources.size());
  const test::TemporaryFolder folder;
  write_distance_matrix(folder.path() / "d.npy", solver, sources);
  const NpzFile file = read_npz(folder.path() / "d.npy");
  const NpyArray& array = npz_array(file, "array");
  EXPECT_EQ(array.shape, (std::vector<std::size_t>{s.positions.size(), s.positions.size()}));
  EXPECT_EQ(array.numbers()[7 * s.positions.size() + 3], matrix(7, 3));
  EXPECT_THROW(distance_matrix(solver, sources, {}, 1000), NoResultError);
}

}  // namespace
}  // namespace kinemesh::geodesics_methods_test
