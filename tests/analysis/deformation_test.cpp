// Strain and curvature against closed forms.
#include "analysis/deformation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/surface_balls.h"
#include "config/error.h"
#include "tests/support/deforming_shapes.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::deformation_test {
namespace {

using test::animate;
using test::make_sheet;

/// Rest and one other frame.
template <class Map>
AnimatedMesh deformed(const test::Sheet& sheet, Map map) {
  auto moved = sheet.positions;
  for (Eigen::Vector3d& p : moved) p = map(p);
  return animate(sheet.topology, {sheet.positions, moved}, 10.0);
}

DeformationOptions with(StrainRegion region, StrainMeasure measure) {
  DeformationOptions options;
  options.region = region;
  options.measure = measure;
  return options;
}

class BothRegions : public ::testing::TestWithParam<StrainRegion> {};
INSTANTIATE_TEST_SUITE_P(Strain, BothRegions,
                         ::testing::Values(StrainRegion::triangles, StrainRegion::ball));

TEST_P(BothRegions, UniaxialStretch) {
  const auto mesh = deformed(make_sheet(100, 60, 4, 1), [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(1.2 * p.x(), p.y(), p.z());
  });
  const auto lambda = deformation_of(mesh, with(GetParam(), StrainMeasure::lambda));
  const auto green = deformation_of(mesh, with(GetParam(), StrainMeasure::green));
  const auto log = deformation_of(mesh, with(GetParam(), StrainMeasure::log));
  const auto root = deformation_of(mesh, with(GetParam(), StrainMeasure::root_log));
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_NEAR(lambda.values.of(v)[0], 1.0, 1e-5);
    EXPECT_NEAR(lambda.values.of(v)[1], 1.44, 1e-4);
    EXPECT_NEAR(green.values.of(v)[1], 0.22, 1e-4);
    EXPECT_NEAR(log.values.of(v)[1], std::log(1.2), 1e-4);
    EXPECT_NEAR(root.values.of(v)[1], std::sqrt(std::log(1.2) + 0.02) - std::sqrt(0.02), 1e-4);
  }
}

TEST_P(BothRegions, SimpleShear) {
  constexpr double g = 0.5;
  const auto mesh = deformed(make_sheet(100, 60, 4, 2), [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x() + g * p.y(), p.y(), 0);
  });
  const auto result = deformation_of(mesh, with(GetParam(), StrainMeasure::lambda));
  const double truth = 1 + g * g / 2 + g * std::sqrt(1 + g * g / 4);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_NEAR(result.values.of(v)[1], truth, 1e-4);
  }
}

TEST_P(BothRegions, ShorteningCountsOnlyInTheNorm) {
  const auto mesh = deformed(make_sheet(60, 60, 4, 3),
                             [](const Eigen::Vector3d& p) { return Eigen::Vector3d(0.8 * p); });
  EXPECT_NEAR(deformation_of(mesh, with(GetParam(), StrainMeasure::log)).largest, 0.0, 1e-6);
  EXPECT_NEAR(deformation_of(mesh, with(GetParam(), StrainMeasure::log_norm)).largest,
              std::sqrt(2.0) * std::log(1.25), 1e-4);
}

TEST_P(BothRegions, RigidMotionIsNoDeformation) {
  const test::Surface sphere = test::sphere(4, 50.0);
  std::vector<std::vector<Eigen::Vector3d>> frames;
  for (int f = 0; f < 4; ++f) {
    frames.push_back(sphere.positions);
    const Eigen::AngleAxisd turn(0.7 * f, Eigen::Vector3d(1, 2, 3).normalized());
    for (Eigen::Vector3d& p : frames.back()) p = turn * p + f * Eigen::Vector3d(100, -50, 20);
  }
  auto options = with(GetParam(), StrainMeasure::green);
  options.curvature_weight = 1.0;
  const auto result = deformation_of(animate(sphere.topology, frames, 10), options);
  for (const float d : result.values.values)
    EXPECT_NEAR(d, 0.0, 1e-3);  // curvature × √area of floats
}

/// A sheet bent around a cylinder without stretch.
Eigen::Vector3d bent(const Eigen::Vector3d& p, double radius) {
  return {radius * std::sin(p.x() / radius), p.y(), radius * std::cos(p.x() / radius) - radius};
}

TEST(Deformation, IsometricBendingHasNoStrainAndTheCylindersCurvature) {
  constexpr double radius = 50.0;
  const auto sheet = make_sheet(120, 80, 2.5, 4);
  const auto mesh = deformed(sheet, [](const Eigen::Vector3d& p) { return bent(p, radius); });
  for (const StrainRegion region : {StrainRegion::triangles, StrainRegion::ball}) {
    const auto strain = deformation_of(mesh, with(region, StrainMeasure::green));
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      EXPECT_NEAR(strain.values.of(v)[1], 0.0, 2e-3);
    }
  }
  auto options = with(StrainRegion::triangles, StrainMeasure::green);
  const auto without = deformation_of(mesh, options);
  options.curvature_weight = 1.0;
  options.curvature_radius = 0.1;
  const auto both = deformation_of(mesh, options);
  double sum = 0.0, count = 0.0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Eigen::Vector3d& p = sheet.positions[v];
    if (p.x() < 12 || p.x() > 108 || p.y() < 12 || p.y() > 68) continue;  // whole balls
    const double change = double{both.values.of(v)[1]} - without.values.of(v)[1];
    EXPECT_NEAR(change / both.root_area_mm, 1.0 / radius, 0.1 / radius);  // irregular edges
    sum += change / both.root_area_mm;
    count += 1.0;
  }
  EXPECT_NEAR(sum / count, 1.0 / radius, 0.02 / radius);
}

TEST(Deformation, CurvatureOfASphereThatGrows) {
  // From radius 40 to 50, and from a sphere: the change is 2/40 − 2/50.
  const test::Surface sphere = test::sphere(4, 40.0);
  auto larger = sphere.positions;
  for (Eigen::Vector3d& p : larger) p *= 1.25;
  auto options = with(StrainRegion::triangles, StrainMeasure::green);
  options.curvature_weight = 1.0;
  const auto mesh = animate(sphere.topology, {sphere.positions, larger}, 10.0);
  const auto result = deformation_of(mesh, options);
  double sum = 0.0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double change = result.values.of(v)[1] - 0.5 * (1.25 * 1.25 - 1.0);
    // Where five edges meet, few edges stand for the ball.
    EXPECT_NEAR(change / result.root_area_mm, 0.01, 0.001);
    sum += change / result.root_area_mm;
  }
  EXPECT_NEAR(sum / static_cast<double>(mesh.vertex_count()), 0.01, 0.0002);
}

TEST(Deformation, DirectionOfTheStretch) {
  const Eigen::Vector3d along = Eigen::Vector3d(2, 1, 0).normalized();
  const auto mesh = deformed(make_sheet(80, 80, 4, 5), [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p + 0.3 * along * along.dot(p));
  });
  DeformationOptions options;
  options.directions = true;
  const auto result = deformation_of(mesh, options);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const float* d = result.directions.data() + 3 * (2 * v + 1);
    EXPECT_NEAR(std::abs(along.dot(Eigen::Vector3d(d[0], d[1], d[2]))), 1.0, 1e-4);
  }
}

TEST(Deformation, RestPoseByFrameMeanAndOtherTake) {
  const auto sheet = make_sheet(60, 60, 5, 6);
  std::vector<std::vector<Eigen::Vector3d>> frames(3, sheet.positions);
  for (Eigen::Vector3d& p : frames[1]) p.x() *= 1.1;
  for (Eigen::Vector3d& p : frames[2]) p.x() *= 1.2;
  const auto mesh = animate(sheet.topology, frames, 10);
  DeformationOptions options = with(StrainRegion::triangles, StrainMeasure::log);
  options.rest_frame = 1;
  EXPECT_NEAR(deformation_of(mesh, options).values.of(3)[2], std::log(1.2 / 1.1), 1e-5);
  options.rest = RestPose::mean;
  EXPECT_NEAR(deformation_of(mesh, options).values.of(3)[2], std::log(1.2 / 1.1), 1e-5);
  const Mesh other = mesh.mesh_at(2);
  options.measure = StrainMeasure::log_norm;
  EXPECT_NEAR(deformation_of(mesh, options, {}, &other).values.of(3)[0], std::log(1.2), 1e-5);
  options.rest = RestPose::frame;
  options.rest_frame = 3;
  EXPECT_THROW(deformation_of(mesh, options), UsageError);
}

TEST(Deformation, ThreadsAndScaleDoNotMatter) {
  const auto sheet = make_sheet(100, 100, 3, 7);
  const test::Bump bump{{50, 50}, 15, 0.5, 0.1, 10};
  const auto mesh = test::bumps(sheet, {bump}, 1, 100);  // more than one block of frames
  DeformationOptions options;
  options.curvature_weight = 0.5;
  const auto one = deformation_of(mesh, options, RunContext().set_threads(1));
  const auto two = deformation_of(mesh, options, RunContext().set_threads(2));
  EXPECT_TRUE(
      std::equal(one.values.values.begin(), one.values.values.end(), two.values.values.begin()));
  AnimatedMesh larger = mesh;
  for (float& x : larger.positions()) x *= 1000.0F;
  const auto scaled = deformation_of(larger, options);
  for (std::size_t i = 0; i < one.values.values.size(); ++i) {
    EXPECT_NEAR(scaled.values.values[i], one.values.values[i], 3e-3);
  }
}

TEST(Deformation, BadInput) {
  const auto sheet = make_sheet(20, 20, 5, 8);
  auto broken = animate(sheet.topology, {sheet.positions, sheet.positions}, 10);
  broken.position(1, 7).y() = std::numeric_limits<float>::quiet_NaN();
  try {
    deformation_of(broken);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().frame, 2);
    EXPECT_NE(error.details().what.find("vertex 7"), std::string::npos);
  }
  EXPECT_THROW(deformation_of(AnimatedMesh(sheet.topology, 0, 10)), NoResultError);
  const auto points = Topology::create(3, {});
  EXPECT_THROW(deformation_of(animate(points, {{{}, {}, {}}}, 10)), NoResultError);
  const auto flat = Topology::create(3, {{0, 1, 2}});
  EXPECT_THROW(deformation_of(animate(flat, {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}, 10)),
               NoResultError);
  const Mesh other = test::sphere(1, 10).mesh();
  EXPECT_THROW(deformation_of(animate(sheet.topology, {sheet.positions}, 10), {}, {}, &other),
               InputError);
}

TEST(Deformation, DegenerateNonManifoldAndIsolatedPartsDoNoHarm) {
  // A sheet, a triangle without area, a third triangle on an edge, a vertex without faces.
  const auto sheet = make_sheet(20, 20, 2, 9);
  auto faces = sheet.topology->faces();
  auto positions = sheet.positions;
  const auto count = static_cast<VertexIndex>(positions.size());
  positions.emplace_back(5, 5, 10);
  positions.emplace_back(50, 50, 50);
  faces.push_back({faces[0][0], faces[0][1], count});
  faces.push_back({0, 1, 2});  // on one line: the sheet's straight rim
  auto moved = positions;
  for (Eigen::Vector3d& p : moved) p.x() *= 1.1;
  const auto mesh = animate(Topology::create(positions.size(), faces), {positions, moved}, 10);
  for (const StrainRegion region : {StrainRegion::triangles, StrainRegion::ball}) {
    auto options = with(region, StrainMeasure::log);
    options.curvature_weight = 1.0;
    const auto result = deformation_of(mesh, options);
    EXPECT_EQ(result.degenerate_faces, 1U);
    EXPECT_EQ(result.isolated_vertices, 1U);
    for (const float d : result.values.values) EXPECT_TRUE(std::isfinite(d));
    EXPECT_EQ(result.values.of(count + 1)[1], 0.0F);
  }
}

}  // namespace
}  // namespace kinemesh::deformation_test
