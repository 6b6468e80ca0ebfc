#include "reconstruct/topology_reuse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "config/error.h"
#include "reconstruct/carry.h"
#include "tests/reconstruct/cloud.h"
#include "tests/support/samples.h"

namespace kinemesh::topology_reuse_test {
namespace {

using test::cap;
using test::make_take;
using test::scatter;

Mesh mesh_of(const MarkerSequence& take, const TriangulateResult& result) {
  return carry_topology(result.topology, take, result.frame).animation.mesh_at(result.frame);
}

void expect_sound(const TriangulateResult& result) {
  EXPECT_TRUE(result.topology->is_manifold());
  EXPECT_EQ(result.topology->component_count(), 1U);
  EXPECT_EQ(result.topology->isolated_vertex_count(), 0U);
  EXPECT_EQ(result.topology->euler_characteristic(),
            1 - static_cast<int64_t>(result.openings.size()));
}

/// Faces from their smallest vertex on, ascending.
std::vector<Triangle> sorted_faces(const Topology& topology) {
  std::vector<Triangle> faces = topology.faces();
  for (Triangle& t : faces) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(faces.begin(), faces.end());
  return faces;
}

TEST(TopologyReuse, SameMarkersInAnotherOrderKeepEveryFace) {
  const MarkerSequence take = make_take({scatter(cap(80, 1.3), 12, 4)});
  const Mesh previous = mesh_of(take, triangulate(take));
  std::vector<std::size_t> order(take.marker_count());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = order.size() - 1 - i;
  const auto reused = reuse_topology(previous, take.select(order));
  expect_sound(reused.triangulation);
  EXPECT_TRUE(reused.missing.empty() && reused.added.empty());
  std::set<std::set<VertexIndex>> before, after;
  for (const auto& [a, b, c] : previous.topology->faces()) before.insert({a, b, c});
  const auto last = static_cast<VertexIndex>(order.size() - 1);
  for (const auto& [a, b, c] : reused.triangulation.topology->faces()) {
    after.insert({last - a, last - b, last - c});
  }
  EXPECT_EQ(before, after);
}

TEST(TopologyReuse, MissingAndNewMarkersAreSaidAndMended) {
  const MarkerSequence take = make_take({scatter(cap(80, 1.3), 12, 4)});
  const std::size_t n = take.marker_count();
  std::vector<std::size_t> first, second;
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 13 != 5) first.push_back(i);   // the first take lacks some
    if (i % 11 != 3) second.push_back(i);  // the second others, of the middle and of the rim
  }
  const MarkerSequence before = take.select(first), after = take.select(second);
  const Mesh previous = mesh_of(before, triangulate(before));
  const auto reused = reuse_topology(previous, after);
  expect_sound(reused.triangulation);
  std::size_t missing = 0, added = 0, shared = 0;
  for (std::size_t i = 0; i < n; ++i) {
    missing += i % 11 == 3 && i % 13 != 5 ? 1 : 0;
    added += i % 13 == 5 && i % 11 != 3 ? 1 : 0;
  }
  EXPECT_EQ(reused.missing.size(), missing);
  EXPECT_EQ(reused.added.size(), added);
  EXPECT_EQ(reused.triangulation.diagnostics.warnings.size(), missing + added);
  // Edges away from the changes are the same.
  std::set<std::set<std::string>> edges;
  for (const Edge& e : previous.topology->edges()) {
    edges.insert({before.markers()[e.vertices[0]].label, before.markers()[e.vertices[1]].label});
  }
  for (const Edge& e : reused.triangulation.topology->edges()) {
    shared +=
        edges.contains({after.markers()[e.vertices[0]].label, after.markers()[e.vertices[1]].label})
            ? 1
            : 0;
  }
  EXPECT_GT(shared, reused.triangulation.topology->edge_count() / 2);
}

TEST(TopologyReuse, SurpriseTakesOverTheOpeningsOfHappy) {
  const auto happy = test::make_sample("anna_happy");
  const auto surprise = test::make_sample("anna_surprise");
  std::vector<std::size_t> face(happy.face_marker_count());
  for (std::size_t i = 0; i < face.size(); ++i) face[i] = i;
  const MarkerSequence first = happy.truth.select(face), second = surprise.truth.select(face);
  const auto triangulated = triangulate(first);
  const auto reused = reuse_topology(mesh_of(first, triangulated), second);
  expect_sound(reused.triangulation);
  EXPECT_EQ(sorted_faces(*reused.triangulation.topology), sorted_faces(*triangulated.topology));
  ASSERT_EQ(reused.triangulation.openings.size(), triangulated.openings.size());
  for (std::size_t i = 0; i < triangulated.openings.size(); ++i) {
    EXPECT_EQ(reused.triangulation.openings[i].name, triangulated.openings[i].name);
    auto loop = reused.triangulation.openings[i].loop, expected = triangulated.openings[i].loop;
    EXPECT_TRUE(std::is_permutation(loop.begin(), loop.end(), expected.begin(), expected.end()));
  }
}

TEST(TopologyReuse, MarkersOfOneNameKeepTheirOrder) {
  MarkerSequence take = make_take({scatter(cap(80, 1.3), 12, 4)});
  take.markers()[7].label = take.markers()[3].label;
  const auto reused = reuse_topology(mesh_of(take, triangulate(take)), take);
  EXPECT_TRUE(reused.missing.empty() && reused.added.empty());
}

TEST(TopologyReuse, OpeningsAskedForBesideItAreNotPassedOver) {
  const MarkerSequence take = make_take({scatter(cap(80, 1.3), 12, 4)});
  TriangulateOptions options;
  options.openings.mouth = OpeningMode::open;
  const auto reused = reuse_topology(mesh_of(take, triangulate(take)), take, options);
  const auto& warnings = reused.triangulation.diagnostics.warnings;
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings.front().find("--mouth"), std::string::npos);
}

TEST(TopologyReuse, AMeshOfAnotherSubjectIsRefused) {
  MarkerSequence take = make_take({scatter(cap(80, 1.3), 15, 4)});
  Mesh previous = mesh_of(take, triangulate(take));
  for (auto& marker : take.markers()) marker.label = "other_" + marker.label;
  EXPECT_THROW(reuse_topology(previous, take), NoResultError);
  previous.vertex_names.clear();
  EXPECT_THROW(reuse_topology(previous, take), InputError);
}

}  // namespace
}  // namespace kinemesh::topology_reuse_test
