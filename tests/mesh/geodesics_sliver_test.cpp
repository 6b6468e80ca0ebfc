// Exact distances where triangles are thin: everything is reached, in both directions alike, at the
// distance that is known for a plane.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/intrinsic_lengths.h"
#include "tests/support/data.h"
#include "tests/support/sanitizers.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::geodesics_sliver_test {
namespace {

using test::rectangle;
using test::Surface;

/// 0, step, 2 step, … as a file with floats holds them.
std::vector<double> steps(int count, double step) {
  std::vector<double> result;
  for (int k = 0; k < count; ++k) result.push_back(static_cast<float>(k * step));
  return result;
}

void expect_straight_distances(const Surface& s, VertexIndex every, double tolerance) {
  const GeodesicSolver solver(s.topology, s.positions);
  for (VertexIndex source = 0; source < s.positions.size(); source += every) {
    const GeodesicField field = solver.solve(source);
    for (VertexIndex v = 0; v < s.positions.size(); ++v) {
      const double straight = (s.positions[v] - s.positions[source]).norm();
      ASSERT_NEAR(field.distances[v], straight, tolerance * straight) << source << " to " << v;
    }
  }
}

TEST(GeodesicsSliver, StripOfSixVerticesAlongItsBoundary) {
  for (const double height : {2.806042721203994e-05, 1e-3, 1e-7}) {
    Surface s = rectangle({0, 1, 2}, {0, height}, 1);
    s.topology = Topology::create(6, {{0, 1, 4}, {0, 4, 3}, {1, 2, 4}, {2, 5, 4}});
    const GeodesicField field = GeodesicSolver(s.topology, s.positions).solve(5);
    EXPECT_DOUBLE_EQ(field.distances[3], 2.0);
    expect_straight_distances(s, 1, 1e-14);
  }
}

TEST(GeodesicsSliver, FlatGridsOfEveryAspect) {
  uint64_t seed = 0;
  for (const double aspect : {1.0, 0.03, 3.447124558091775e-4, 1e-5, 1e-6}) {
    for (int trial = 0; trial < (test::under_sanitizers ? 1 : 3); ++trial) {
      expect_straight_distances(rectangle(steps(25, 1.0), steps(25, aspect), ++seed), 78, 1e-11);
    }
  }
}

TEST(GeodesicsSliver, CellsOfVeryDifferentSizes) {
  for (const double least : {1e-2, 1e-4, 1e-6, 3e-8}) {
    const auto rounded = [&](std::vector<double> values) {
      for (double& value : values) value = static_cast<float>(value);
      return values;
    };
    for (uint64_t seed = 0; seed < 4; ++seed) {
      expect_straight_distances(
          rectangle(rounded({-1, -least, 0, least, 2 * least, 3.3 * least, .3, .6, 1}),
                    rounded({-.5, -2 * least, 0, least, 2.5 * least, .25, .5, .8, 1}), seed),
          test::under_sanitizers ? 27 : 9, 1e-9);
    }
  }
}

TEST(GeodesicsSliver, PathsOfFlatGridsAreAsLongAsTheirDistance) {
  const Surface s = rectangle(steps(25, 1.0), steps(25, 3.447124558091775e-4), 3);
  const GeodesicSolver solver(s.topology, s.positions);
  for (const VertexIndex source : {0U, 104U, 299U}) {
    const GeodesicField field = solver.solve(source);
    for (VertexIndex v = 0; v < s.positions.size(); v += 11) {
      EXPECT_NEAR(solver.path_to(field, v).length, field.distances[v], 1e-9 * field.distances[v]);
    }
  }
}

TEST(GeodesicsSliver, PathsThroughTrianglesWithoutAreaAreNoDetours) {
  const Surface s = rectangle(steps(12, 1.0), steps(12, 1e-10), 5);
  const GeodesicSolver solver(s.topology, s.positions);
  const GeodesicField field = solver.solve(17);
  for (VertexIndex v = 0; v < s.positions.size(); v += 5) {
    EXPECT_NEAR(solver.path_to(field, v).length, field.distances[v], 1e-8) << v;
  }
}

TEST(GeodesicsSliver, ARadiusFindsTheSameVertices) {
  const Surface s = rectangle(steps(25, 1.0), steps(25, 3.447124558091775e-4), 3);
  const GeodesicSolver solver(s.topology, s.positions);
  const auto found = solver.within(vertex_point(*s.topology, 312), 5.5);
  EXPECT_EQ(found.size(), 11U * 25U);
  for (const auto& [v, distance] : found) {
    EXPECT_NEAR(distance, (s.positions[v] - s.positions[312]).norm(), 1e-10);
  }
}

/// No vertex is unreached, further away than along edges, or further than a neighbour and the edge.
void expect_consistent(const GeodesicSolver& solver, const GeodesicField& field,
                       const IntrinsicLengths& edges, const std::string& place) {
  GeodesicOptions along_edges;
  along_edges.method = GeodesicMethod::dijkstra;
  const GeodesicField upper = solver.solve(field.sources, along_edges);
  const std::vector<double>& d = field.distances;
  for (VertexIndex v = 0; v < d.size(); ++v) {
    ASSERT_LE(d[v], upper.distances[v] * (1 + 1e-12)) << place << " to " << v;
    ASSERT_TRUE(std::isfinite(d[v]) || !std::isfinite(upper.distances[v])) << place;
  }
  const Topology& topology = solver.topology();
  for (HalfedgeIndex h = 0; h < edges.lengths.size(); ++h) {
    const double a = d[topology.from(h)], b = d[topology.to(h)];
    ASSERT_LE(std::abs(a - b), edges.lengths[h] + 1e-11 * std::max(a, b)) << place;
  }
}

TEST(GeodesicsSliver, ChangingPentFromManySources) {
  const std::array<VertexIndex, 4> sources{0, 400, 846, 1500};
  for (int frame = 0; frame < 50; frame += test::under_sanitizers ? 25 : 5) {
    const std::string number = std::to_string(frame);
    const std::string name = "mesh_" + std::string(4 - number.size(), '0') + number + ".ply";
    KINEMESH_NEED_DATA(std::filesystem::path("changing_pent") / name);
    const Mesh mesh =
        read_mesh(builtin_mesh_formats(), test::data_folder() / "changing_pent" / name);
    std::vector<Eigen::Vector3d> positions;
    for (const auto& p : mesh.positions) positions.push_back(p.cast<double>());
    const IntrinsicLengths edges = intrinsic_lengths(*mesh.topology, positions);
    const GeodesicSolver solver(mesh);
    std::array<GeodesicField, 4> fields;
    for (std::size_t s = 0; s < sources.size(); ++s) {
      fields[s] = solver.solve(sources[s]);
      expect_consistent(solver, fields[s], edges, name + " from " + std::to_string(sources[s]));
      for (std::size_t o = 0; o < s; ++o) {
        const double there = fields[o].distances[sources[s]],
                     back = fields[s].distances[sources[o]];
        EXPECT_NEAR(there, back, 1e-11 * there) << name << ": " << sources[o] << ", " << sources[s];
      }
    }
  }
}

}  // namespace
}  // namespace kinemesh::geodesics_sliver_test
