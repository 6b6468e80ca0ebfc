// Landmarks by hand in dense matching: met exactly, without folds, or named.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "analysis/full_matching/full_matching.h"
#include "analysis/full_matching/landmark_warp.h"
#include "analysis/map_evaluation.h"
#include "analysis/spherical/orientation.h"
#include "config/error.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesics.h"
#include "tests/support/data.h"
#include "tests/support/sanitizers.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::landmark_matching_test {
namespace {

AnimatedMesh still(const test::Surface& surface) {
  AnimatedMesh mesh(surface.topology, 1, 0);
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
    mesh.position(0, v) = surface.positions[v].cast<float>();
  return mesh;
}

/// Turned about the axis by an angle that depends on the height: no rotation undoes it.
Eigen::Vector3d twisted(const Eigen::Vector3d& p, double angle) {
  return Eigen::AngleAxisd(angle * p.z() / p.norm(), Eigen::Vector3d::UnitZ()) * p;
}

/// Vertices far from each other, each with where the twist takes it.
std::vector<LandmarkPair> twist_landmarks(const test::Surface& source, const test::Surface& target,
                                          std::size_t count, double angle) {
  std::vector<LandmarkPair> pairs;
  std::vector<double> far(source.positions.size(), 1e9);
  VertexIndex next = 0;
  while (pairs.size() < count) {
    const Eigen::Vector3d goal = twisted(source.positions[next], angle);
    VertexIndex nearest = 0;
    for (VertexIndex v = 0; v < target.positions.size(); ++v) {
      if ((target.positions[v] - goal).norm() < (target.positions[nearest] - goal).norm())
        nearest = v;
    }
    pairs.push_back({vertex_point(*source.topology, next), vertex_point(*target.topology, nearest),
                     "mark " + std::to_string(next)});
    for (VertexIndex v = 0; v < far.size(); ++v)
      far[v] = std::min(far[v], (source.positions[v] - source.positions[next]).norm());
    next = static_cast<VertexIndex>(std::ranges::max_element(far) - far.begin());
  }
  return pairs;
}

void expect_met(const FullMatching& m, const AnimatedMesh& source, const AnimatedMesh& target,
                const std::vector<LandmarkPair>& pairs) {
  EXPECT_TRUE(m.check.valid()) << m.check.folded << " folds, " << m.check.solid_angle;
  const MapEvaluation e =
      evaluate_map(m.forward, truth_from_pairs(pairs, source.topology()), target.mesh_at(0));
  EXPECT_EQ(e.errors.unmapped, 0U);
  EXPECT_LT(e.errors.worst, 1e-4);
}

TEST(LandmarkMatching, AHundredLandmarksOfATwistAreMetExactlyWithoutAFold) {
  KINEMESH_LEAVE_TO_RELEASE("SeventeenLandmarksOfCatsInDifferentPosesAreMet");
  const test::Surface a = test::sphere(4, 50), b = test::sphere(4, 20);
  for (const std::size_t count : {1, 4, 25, 100}) {
    const auto pairs = twist_landmarks(a, b, count, 0.8);
    const FullMatching m = match_surfaces(still(a), still(b), {}, {}, pairs);
    expect_met(m, still(a), still(b), pairs);
    for (const LandmarkPair& pair : pairs) {
      const auto corner =
          std::ranges::max_element(pair.source.weights) - pair.source.weights.begin();
      EXPECT_EQ(m.forward.confidence[a.topology->faces()[pair.source.face][corner]], 1.0);
    }
  }
}

TEST(LandmarkMatching, NoTriangleTurnsOverWhileLandmarksMove) {
  const test::Surface ball = test::sphere(3, 1);
  const spherical::RingMesh mesh(*ball.topology);
  std::vector<full_matching::Anchor> anchors;
  for (VertexIndex v = 0; v < 40; ++v) {
    anchors.push_back({v, {}, twisted(ball.positions[v], 1.0).normalized()});
  }
  std::vector<Eigen::Vector3d> points = ball.positions;
  const auto away = full_matching::warp_to_anchors(mesh, ball.positions, points, anchors, {});
  EXPECT_TRUE(away.empty());
  for (const auto& a : anchors) EXPECT_EQ(points[a.vertex], a.goal);
  EXPECT_TRUE(check_sphere(*ball.topology, points).valid());
}

TEST(LandmarkMatching, WhatCannotBeReachedIsReportedAndStillNothingFolds) {
  const test::Surface ball = test::sphere(1, 1);  // 42 vertices: no room to go round each other
  const spherical::RingMesh mesh(*ball.topology);
  std::vector<full_matching::Anchor> anchors;
  for (VertexIndex v = 0; v < ball.positions.size(); ++v) {
    Eigen::Vector3d goal = ball.positions[v];
    if (v < 2) goal = ball.positions[1 - v];  // two are exchanged, all others stay
    anchors.push_back({v, {}, goal.normalized()});
  }
  std::vector<Eigen::Vector3d> points = ball.positions;
  const auto away = full_matching::warp_to_anchors(mesh, ball.positions, points, anchors, {});
  EXPECT_EQ(away, (std::vector<std::size_t>{0, 1}));
  EXPECT_TRUE(check_sphere(*ball.topology, points).valid());
}

TEST(LandmarkMatching, LandmarksThatContradictEachOtherAreNamed) {
  const test::Surface ball = test::sphere(2, 10);
  const AnimatedMesh mesh = still(ball);
  const auto at = [&](VertexIndex v) { return vertex_point(*ball.topology, v); };
  for (const std::vector<LandmarkPair>& pairs :
       {std::vector<LandmarkPair>{{at(1), at(2), "nose"}, {at(1), at(3), "chin"}},
        std::vector<LandmarkPair>{{at(1), at(3), "nose"}, {at(2), at(3), "chin"}}}) {
    try {
      match_surfaces(mesh, mesh, {}, {}, pairs);
      ADD_FAILURE();
    } catch (const NoResultError& e) {
      EXPECT_NE(std::string(e.what()).find("1 (nose) and 2 (chin)"), std::string::npos) << e.what();
    }
  }
  const std::vector<LandmarkPair> inside{{{0, {0.3, 0.3, 0.4}}, at(1), "tip"}};
  EXPECT_THROW(match_surfaces(mesh, mesh, {}, {}, inside), InputError);
  const std::vector<LandmarkPair> beyond{{at(0), {100000, {1, 0, 0}}, "tip"}};
  EXPECT_THROW(match_surfaces(mesh, mesh, {}, {}, beyond), InputError);
}

TEST(LandmarkMatching, SeventeenLandmarksOfCatsInDifferentPosesAreMet) {
  KINEMESH_NEED_DATA("tosca_cat/cat0.off");
  const auto folder = test::data_folder() / "tosca_cat";
  const AnimatedMesh a = read_animation(builtin_mesh_formats(), folder / "cat0.off");
  const AnimatedMesh b = read_animation(builtin_mesh_formats(), folder / "cat3.off");
  const auto list_a = read_vertex_list(folder / "cat0.vts", a.vertex_count());
  const auto list_b = read_vertex_list(folder / "cat3.vts", b.vertex_count());
  std::vector<LandmarkPair> pairs;
  for (std::size_t k = 0; k < list_a.size() && pairs.size() < 17; k += 293) {
    pairs.push_back(
        {vertex_point(a.topology(), list_a[k]), vertex_point(b.topology(), list_b[k]), {}});
  }
  expect_met(match_surfaces(a, b, {}, {}, pairs), a, b, pairs);
}

}  // namespace
}  // namespace kinemesh::landmark_matching_test
