#include "reconstruct/triangulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "config/error.h"
#include "tests/reconstruct/cloud.h"

namespace kinemesh::triangulate_test {
namespace {

using test::cap;
using test::make_take;
using test::scatter;

void expect_sound(const TriangulateResult& result, int64_t euler) {
  const Topology& t = *result.topology;
  EXPECT_TRUE(t.is_manifold());
  EXPECT_EQ(t.component_count(), 1U);
  EXPECT_EQ(t.isolated_vertex_count(), 0U);
  EXPECT_EQ(t.euler_characteristic(), euler);
}

/// Mean cosine between the faces' normals and the directions from `inside`.
double outward_share(const Topology& t, const Points& p, const Eigen::Vector3d& inside) {
  double out = 0;
  for (const auto& [a, b, c] : t.faces()) {
    out += (p[b] - p[a]).cross(p[c] - p[a]).dot(p[a] + p[b] + p[c] - 3 * inside) > 0 ? 1 : 0;
  }
  return out / static_cast<double>(t.face_count());
}

using EdgeSet = std::set<std::array<std::string, 2>>;

/// Directed edges by marker name.
EdgeSet named_edges(const MarkerSequence& take, const Topology& t) {
  EdgeSet edges;
  for (HalfedgeIndex h = 0; h < 3 * t.face_count(); ++h) {
    edges.insert({take.markers()[t.from(h)].label, take.markers()[t.to(h)].label});
  }
  return edges;
}

TEST(Triangulate, CapOfASphereIsADiskThatLooksOutwards) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Points points = scatter(cap(80, 1.5), 9, seed);
    const auto result = triangulate(make_take({points}));
    expect_sound(result, 1);
    EXPECT_TRUE(result.openings.empty());
    EXPECT_EQ(result.diagnostics.method, "advancing front");
    EXPECT_EQ(outward_share(*result.topology, points, {0, 0, 0}), 1.0);
    EXPECT_LE(result.diagnostics.longest_rim_edge, 2.2);
  }
}

TEST(Triangulate, ClosedSphereIsTheConvexHull) {
  const Points points = scatter(cap(80, std::numbers::pi), 12, 7);
  const auto result = triangulate(make_take({points}));
  expect_sound(result, 2);
  EXPECT_EQ(outward_share(*result.topology, points, {0, 0, 0}), 1.0);
}

TEST(Triangulate, SameWhateverPoseAndMarkerOrder) {
  Points points = scatter(cap(80, 1.3), 9, 3);
  // Mirror pairs about x = 0 make ties; the result must not depend on how they are broken.
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i)
    points.push_back({-points[i].x() - 200, points[i].y(), points[i].z()});
  points.resize(n);
  const MarkerSequence take = make_take({points});
  const EdgeSet expected = named_edges(take, *triangulate(take).topology);
  const Eigen::Affine3d move = Eigen::Translation3d(700, -1200, 400) *
                               Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, -1).normalized());
  Points moved;
  for (const auto& p : points) moved.emplace_back(move * p);
  const MarkerSequence moved_take = make_take({moved});
  EXPECT_EQ(named_edges(moved_take, *triangulate(moved_take).topology), expected);

  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  const MarkerSequence shuffled = take.select(order);
  EXPECT_EQ(named_edges(shuffled, *triangulate(shuffled).topology), expected);
}

TEST(Triangulate, MirrorSymmetricMarkersHaveNoTies) {
  Points points;
  for (const auto& p : scatter(cap(80, 1.3), 10, 3)) {
    if (p.x() < 5) continue;
    points.push_back(p);
    points.push_back({-p.x(), p.y(), p.z()});
  }
  const MarkerSequence take = make_take({points});
  const auto result = triangulate(take);
  expect_sound(result, 1);
  std::vector<std::size_t> order(points.size());
  std::iota(order.rbegin(), order.rend(), std::size_t{0});
  const MarkerSequence reversed = take.select(order);
  EXPECT_EQ(named_edges(reversed, *triangulate(reversed).topology),
            named_edges(take, *result.topology));
}

TEST(Triangulate, OpenAndClosedBodiesGiveAMesh) {
  // A stretched closed capsule, and a tube open at both ends.
  const auto capsule = [](double u, double v) {
    const Eigen::Vector3d p = cap(100, std::numbers::pi)(u, v);
    return Eigen::Vector3d(p.x(), 0.7 * p.y(), 3 * p.z());
  };
  expect_sound(triangulate(make_take({scatter(capsule, 35, 2)})), 2);
  const auto tube = [](double u, double v) {
    const double phi = 2 * std::numbers::pi * v;
    return Eigen::Vector3d(150 * std::cos(phi), 100 * std::sin(phi), 600 * u);
  };
  const auto result = triangulate(make_take({scatter(tube, 35, 2)}));
  expect_sound(result, 0);
  ASSERT_EQ(result.openings.size(), 1U);
  EXPECT_EQ(result.openings[0].name, OpeningName::gap);
}

TEST(Triangulate, SaddleAndFlatGridAndSmallCloudsWork) {
  const auto saddle = [](double u, double v) {
    const double x = 200 * u - 100, y = 160 * v - 80;
    return Eigen::Vector3d(x, y, (x * x - y * y) / 250);
  };
  expect_sound(triangulate(make_take({scatter(saddle, 12, 1)})), 1);
  Points grid;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 5; ++j) grid.push_back({10.0 * i, 10.0 * j, 0});
  }
  expect_sound(triangulate(make_take({grid})), 1);
  expect_sound(triangulate(make_take({{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}})), 1);
  expect_sound(triangulate(make_take({{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {10, 10, 3}}})), 1);
}

TEST(Triangulate, MarkersThatAllowNoSurfaceAreRefused) {
  EXPECT_THROW(triangulate(make_take({{{0, 0, 0}, {10, 0, 0}}})), NoResultError);
  EXPECT_THROW(triangulate(make_take({{{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 0, 0}}})),
               NoResultError);
  EXPECT_THROW(triangulate(make_take({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}})),
               NoResultError);
  EXPECT_THROW(triangulate(MarkerSequence::invalid(0, std::vector<Marker>(5), 100)), NoResultError);
  MarkerSequence take = make_take({scatter(cap(80, 1), 20, 1)});
  take.position(0, 2).x() = std::numeric_limits<float>::infinity();
  EXPECT_THROW(triangulate(take), InputError);
  TriangulateOptions options;
  options.frame = 5;
  EXPECT_THROW(triangulate(make_take({scatter(cap(80, 1), 20, 1)}), options), UsageError);
  options = {};
  options.edges = {"m0:nobody"};
  EXPECT_THROW(triangulate(make_take({scatter(cap(80, 1), 20, 1)}), options), UsageError);
}

TEST(Triangulate, ReferenceIsTheFirstFrameWithAllMeasured) {
  const Points points = scatter(cap(80, 1), 20, 1);
  MarkerSequence take = make_take({points, points, points, points});
  take.first_frame = 101;
  take.flags()[take.sample(0, 3)] |= SampleFlag::filled;
  take.flags()[take.sample(1, 1)] |= SampleFlag::filled;
  auto result = triangulate(take);
  EXPECT_EQ(result.frame, 2U);
  EXPECT_EQ(result.frame_number, 103);
  EXPECT_TRUE(result.all_measured);
  EXPECT_EQ(result.diagnostics.frames_measured, 2U);
  for (std::size_t f = 0; f < 4; ++f) take.flags()[take.sample(f, 3)] |= SampleFlag::filled;
  take.flags()[take.sample(3, 4)] |= SampleFlag::filled;
  result = triangulate(take);
  EXPECT_EQ(result.frame, 0U);  // frames 0 and 2 lack one marker each
  EXPECT_FALSE(result.all_measured);
  TriangulateOptions options;
  options.frame = 104;
  EXPECT_EQ(triangulate(take, options).frame, 3U);
}

}  // namespace
}  // namespace kinemesh::triangulate_test
