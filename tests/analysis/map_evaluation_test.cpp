#include "analysis/map_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "mesh/geodesics/geodesics.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::map_evaluation_test {
namespace {

/// A flat square of 20 × 20 mm whose map moves everything one column on: errors are 1 / 20, but for
/// what the map leaves out at the edge.
struct Shifted {
  Mesh mesh = test::plane_grid(20, 0.0, 1).mesh();
  SurfaceMap map, truth;
  Shifted() {
    for (VertexIndex v = 0; v < mesh.positions.size(); ++v) {
      truth.points.push_back(vertex_point(*mesh.topology, v));
      map.points.push_back(v % 21 == 20 ? SurfacePoint{} : vertex_point(*mesh.topology, v + 1));
      map.confidence.push_back(v < 200 ? 0.2 : 0.9);
    }
  }
};

TEST(MapEvaluation, KnowsTheErrorsOfAShift) {
  const Shifted s;
  const MapEvaluation e = evaluate_map(s.map, truth_from_map(s.truth), s.mesh, {.cutoff = 0.1});
  EXPECT_NEAR(e.root_area_mm, 20.0, 1e-9);
  EXPECT_EQ(e.errors.unmapped, 21U);
  EXPECT_EQ(e.errors.sorted.size(), 420U);
  EXPECT_NEAR(e.errors.mean, 0.05, 1e-9);
  EXPECT_NEAR(e.errors.median, 0.05, 1e-9);
  EXPECT_NEAR(e.errors.worst, 0.05, 1e-9);
  EXPECT_NEAR(e.errors.share_within(0.0499), 0.0, 1e-12);
  EXPECT_NEAR(e.errors.share_within(0.0501), 420.0 / 441.0, 1e-12);
  EXPECT_NEAR(e.errors.area_under_curve, 0.5 * 420.0 / 441.0, 1e-9);
  EXPECT_NEAR(e.confidence_ratio, 1.0, 1e-9);
  EXPECT_FALSE(e.mirrored.has_value());
}

TEST(MapEvaluation, TheTruthHasNoErrorAndFewerPlacesMayBeMeasured) {
  const Shifted s;
  const MapEvaluation e = evaluate_map(s.truth, truth_from_map(s.truth), s.mesh, {.samples = 40});
  EXPECT_EQ(e.errors.sorted.size(), 40U);
  EXPECT_NEAR(e.errors.worst, 0.0, 1e-9);
  EXPECT_NEAR(e.errors.area_under_curve, 1.0, 1e-9);
}

TEST(MapEvaluation, ErrorsGoRoundWhatIsCutOut) {
  const test::Surface ring = test::plane_with_hole(20, 5, 15);
  const Mesh mesh = ring.mesh();
  const auto at = [&](double x, double y) {
    const auto found = std::ranges::find(ring.positions, Eigen::Vector3d(x, y, 0));
    return static_cast<VertexIndex>(found - ring.positions.begin());
  };
  const VertexIndex left = at(4, 10), right = at(16, 10);  // on both sides of the hole
  SurfaceMap map;
  map.points.resize(mesh.positions.size());
  map.points[left] = vertex_point(*mesh.topology, right);
  const MapEvaluation e =
      evaluate_map(map, truth_from_lists({left}, {left}, {}, *mesh.topology), mesh);
  // Round the corner (5, 5) … (15, 5) of the hole.
  const double around = 2.0 * std::hypot(1.0, 5.0) + 10.0;
  EXPECT_NEAR(e.errors.mean, around / std::sqrt(300.0), 1e-9);
}

TEST(MapEvaluation, TheMirrorImageCountsWhereItIsAllowed) {
  const Mesh mesh = test::plane_grid(20, 0.0, 1).mesh();
  SurfaceMap map;
  std::vector<VertexIndex> list, mirrored;
  for (VertexIndex v = 0; v < mesh.positions.size(); ++v) {
    const VertexIndex other = v - v % 21 + (20 - v % 21);
    map.points.push_back(vertex_point(*mesh.topology, other));
    list.push_back(v);
    mirrored.push_back(other);
  }
  const MapEvaluation e =
      evaluate_map(map, truth_from_lists(list, list, mirrored, *mesh.topology), mesh);
  EXPECT_GT(e.errors.mean, 0.4);
  ASSERT_TRUE(e.mirrored && e.either);
  EXPECT_NEAR(e.mirrored->worst, 0.0, 1e-9);
  EXPECT_NEAR(e.either->worst, 0.0, 1e-9);
}

TEST(MapEvaluation, RefusesWhatDoesNotFit) {
  const Shifted s;
  const Mesh small = test::plane_grid(3, 0.0, 1).mesh();
  EXPECT_THROW(evaluate_map(s.map, truth_from_map(s.truth), small), InputError);
  SurfaceMap none;
  none.points.resize(s.map.points.size());
  EXPECT_THROW(evaluate_map(none, truth_from_map(s.truth), s.mesh), NoResultError);
  none.points.resize(7);
  EXPECT_THROW(evaluate_map(none, truth_from_map(s.truth), s.mesh), InputError);
  EXPECT_THROW(truth_from_lists({1, 2}, {1}, {}, *s.mesh.topology), InputError);
}

}  // namespace
}  // namespace kinemesh::map_evaluation_test
