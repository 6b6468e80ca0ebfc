#include "reconstruct/retarget.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "tests/support/data.h"
#include "tests/support/ict_performer.h"

namespace kinemesh::retarget_test {
namespace {

/// A bumpy sheet whose motion bends and stretches it.
Mesh sheet(int n, double size) {
  Mesh mesh;
  std::vector<Triangle> faces;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const double u = size * x / (n - 1), v = size * y / (n - 1);
      mesh.positions.emplace_back(static_cast<float>(u), static_cast<float>(v),
                                  static_cast<float>(3.0 * std::sin(0.2 * u) * std::cos(0.15 * v)));
    }
  }
  const auto at = [n](int x, int y) { return static_cast<VertexIndex>(y * n + x); };
  for (int y = 0; y + 1 < n; ++y) {
    for (int x = 0; x + 1 < n; ++x) {
      faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  mesh.topology = Topology::create(mesh.positions.size(), std::move(faces));
  return mesh;
}

AnimatedMesh moving(const Mesh& rest, std::size_t frames) {
  AnimatedMesh mesh(rest.topology, frames, 50.0);
  for (std::size_t f = 0; f < frames; ++f) {
    for (VertexIndex v = 0; v < rest.positions.size(); ++v) {
      const Eigen::Vector3f& p = rest.positions[v];
      const auto t = static_cast<float>(f);
      mesh.position(f, v) =
          p + Eigen::Vector3f(0.3F * t, std::sin(0.1F * p.x() * t), t * std::cos(0.2F * p.y()));
    }
  }
  return mesh;
}

SurfaceMap identity_map(const Topology& topology) {
  SurfaceMap map;
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    SurfacePoint p{topology.faces_of(v).front(), {0, 0, 0}};
    const Triangle& t = topology.faces()[p.face];
    p.weights.at(static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin())) = 1.0;
    map.points.push_back(p);
  }
  return map;
}

TEST(Retarget, WhatTheSourceLacksTurnsWithTheBorderOfItsPatch) {
  const Mesh rest = sheet(13, 24.0);
  SurfaceMap half = identity_map(*rest.topology);
  for (VertexIndex v = 0; v < rest.positions.size(); ++v) {
    if (rest.positions[v].x() > 9.0F) half.points[v] = SurfacePoint{};
  }
  AnimatedMesh turned(rest.topology, 1, 50.0);
  const Eigen::Matrix3f turn =
      Eigen::AngleAxisf(0.6F, Eigen::Vector3f(0.2F, 1.0F, 0.3F).normalized()).toRotationMatrix();
  for (VertexIndex v = 0; v < rest.positions.size(); ++v) {
    turned.position(0, v) = turn * rest.positions[v];
  }
  const RetargetResult result = retarget(turned, rest, rest, half);
  EXPECT_GT(result.faces_without_source, 60U);
  for (VertexIndex v = 0; v < rest.positions.size(); ++v) {
    EXPECT_LT((result.animation.position(0, v) - turned.position(0, v)).norm(), 1e-3F) << v;
  }
}

TEST(Retarget, IsExactOnIdenticalMeshes) {
  const Mesh rest = sheet(25, 60.0);
  const AnimatedMesh source = moving(rest, 5);
  const RetargetResult result = retarget(source, rest, rest, identity_map(*rest.topology));
  EXPECT_EQ(result.faces_without_source, 0U);
  EXPECT_DOUBLE_EQ(result.scale, 1.0);
  for (std::size_t i = 0; i < source.positions().size(); ++i) {
    ASSERT_NEAR(result.animation.positions()[i], source.positions()[i], 1e-4F);
  }
}

TEST(Retarget, ARotationOfTheWholeSourceTurnsTheTarget) {
  const Mesh rest = sheet(15, 40.0);
  Mesh larger = rest;
  for (auto& p : larger.positions) p *= 2.0F;
  AnimatedMesh source(rest.topology, 1, 0.0);
  const Eigen::AngleAxisf turn(0.8F, Eigen::Vector3f(1, 2, 0.5F).normalized());
  for (VertexIndex v = 0; v < rest.positions.size(); ++v) {
    source.position(0, v) = turn * rest.positions[v];
  }
  const RetargetResult result = retarget(source, rest, larger, identity_map(*rest.topology));
  EXPECT_NEAR(result.scale, 2.0, 1e-6);
  for (VertexIndex v = 0; v < rest.positions.size(); ++v) {
    EXPECT_LT((result.animation.position(0, v) - turn * larger.positions[v]).norm(), 1e-3F);
  }
}

TEST(Retarget, AnotherFaceWithAnotherConnectivityDoesTheSame) {
  KINEMESH_NEED_DATA("face_ict/meta.json");
  const test::IctModel& model = test::ict_model();
  const test::IctMotion motion = test::make_ict_motion(model, 4, 0.4);
  const test::Performance source = test::perform(model, {.seed = 1}, motion, {.rate_hz = 20});
  const test::Performance target =
      test::perform(model, {.seed = 2}, motion, {.rate_hz = 20, .remesh_vertices = 5000});
  const auto rest_of = [&](const test::Performance& p, uint64_t seed) {
    const test::IctActor actor(model, {.seed = seed}, {});
    Mesh rest{p.mesh.shared_topology(), {}, {}};
    for (const SurfacePoint& point : p.on_model) {
      rest.positions.push_back(position_of(point, *model.topology, actor.rest()).cast<float>());
    }
    return rest;
  };
  const Mesh from = rest_of(source, 1), to = rest_of(target, 2);
  const RetargetResult result =
      retarget(source.mesh, from, to, test::true_map(model, source, target));
  double error = 0.0, motion_size = 0.0;
  for (std::size_t f = 0; f < target.mesh.frame_count(); ++f) {
    for (VertexIndex v = 0; v < to.positions.size(); ++v) {
      error += (result.animation.position(f, v) - target.mesh.position(f, v)).norm();
      motion_size += (target.mesh.position(f, v) - to.positions[v]).norm();
    }
  }
  const auto samples = static_cast<double>(target.mesh.frame_count() * to.positions.size());
  RecordProperty("mean_error_mm", std::to_string(error / samples));
  RecordProperty("mean_motion_mm", std::to_string(motion_size / samples));
  EXPECT_LT(error, 0.35 * motion_size) << error / samples << " of " << motion_size / samples;
}

/// Large source triangles cut through what is round: their middles lie far from a fine target.
TEST(Retarget, EveryFaceOfAFineTargetFindsItsFaceOfACoarseSource) {
  const Mesh coarse = sheet(5, 60.0), fine = sheet(121, 60.0);
  const SurfaceMap all = identity_map(*fine.topology);
  SurfaceMap map;
  for (std::size_t y = 0; y < 5; ++y) {
    for (std::size_t x = 0; x < 5; ++x) map.points.push_back(all.points[30 * (y * 121 + x)]);
  }
  AnimatedMesh source(coarse.topology, 1, 0.0);
  const Eigen::AngleAxisf turn(0.8F, Eigen::Vector3f(1, 2, 0.5F).normalized());
  for (VertexIndex v = 0; v < coarse.positions.size(); ++v) {
    source.position(0, v) = turn * coarse.positions[v];
  }
  const RetargetResult result = retarget(source, coarse, fine, map);
  EXPECT_EQ(result.faces_without_source, 0U);
  for (const VertexIndex v : {121U, 7000U, 14000U}) {
    const Eigen::Vector3f edge = fine.positions[v] - fine.positions[v - 121];
    const Eigen::Vector3f turned =
        result.animation.position(0, v) - result.animation.position(0, v - 121);
    EXPECT_LT((turned - turn * edge).norm(), 2e-3F);
  }
}

TEST(Retarget, WhatDoesNotBelongTogetherIsRefused) {
  const Mesh rest = sheet(8, 20.0), other = sheet(9, 20.0);
  const AnimatedMesh source = moving(rest, 2);
  EXPECT_THROW(retarget(source, other, rest, identity_map(*rest.topology)), InputError);
  SurfaceMap map = identity_map(*rest.topology);
  map.points.pop_back();
  EXPECT_THROW(retarget(source, rest, rest, map), InputError);
  map = identity_map(*rest.topology);
  for (auto& p : map.points) p = {};
  EXPECT_THROW(retarget(source, rest, rest, map), NoResultError);
}

}  // namespace
}  // namespace kinemesh::retarget_test
