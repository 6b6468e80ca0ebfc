#include "reconstruct/carry.h"

#include <gtest/gtest.h>

#include <limits>

#include "config/error.h"
#include "tests/reconstruct/cloud.h"

namespace kinemesh::carry_test {
namespace {

using test::make_take;

/// A square of four triangles about a middle vertex.
std::shared_ptr<const Topology> square() {
  return Topology::create(5, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
}
const Points corners{{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}, {5, 5, 0}};

Points with_middle_at(double x, double y) {
  Points p = corners;
  p[4] = {x, y, 0};
  return p;
}

TEST(Carry, PositionsFlagsAndNamesComeAlong) {
  MarkerSequence take = make_take({corners, with_middle_at(5, 6), corners}, 120);
  take.first_frame = 40;
  take.events = {{"smile", "General", "", 0.5}};
  take.flags()[take.sample(1, 4)] |= SampleFlag::filled;
  take.add_uncertainty();
  take.uncertainty()[take.sample(1, 4)] = 0.7F;
  const auto result = carry_topology(square(), take, 0);
  const AnimatedMesh& mesh = result.animation;
  EXPECT_EQ(mesh.frame_count(), 3U);
  EXPECT_EQ(mesh.rate_hz, 120);
  EXPECT_EQ(mesh.first_frame, 40);
  EXPECT_EQ(mesh.events, take.events);
  EXPECT_EQ(mesh.vertex_names[4], "m4");
  EXPECT_EQ(mesh.position(1, 4).y(), 6.0F);
  EXPECT_EQ(mesh.filled()[9], 1);
  EXPECT_EQ(mesh.filled()[8], 0);
  EXPECT_EQ(mesh.uncertainty()[9], 0.7F);
  EXPECT_EQ(result.quality[1].filled, 1U);
  EXPECT_EQ(result.summary.filled_samples, 1U);
  EXPECT_EQ(result.summary.samples, 15U);
}

TEST(Carry, FlippedDegenerateAndStretchedAreCounted) {
  const auto result = carry_topology(
      square(),
      make_take({corners, with_middle_at(5, -1), with_middle_at(5, 0.1), with_middle_at(5, 9)}), 0);
  EXPECT_EQ(result.quality[0].flipped, 0U);
  EXPECT_FLOAT_EQ(result.quality[0].stretch_max, 1);
  EXPECT_EQ(result.quality[1].flipped, 1U);  // the face at the lower side is turned over
  EXPECT_EQ(result.quality[2].flipped, 0U);
  EXPECT_EQ(result.quality[2].degenerate, 1U);
  // Middle to the upper corners: √26 over √50; to the lower: √106 over √50.
  EXPECT_NEAR(result.quality[3].stretch_min, std::sqrt(26.0 / 50), 1e-6);
  EXPECT_NEAR(result.quality[3].stretch_max, std::sqrt(106.0 / 50), 1e-6);
  const double a = std::sqrt(26.0 / 50) - 1, b = std::sqrt(106.0 / 50) - 1;
  EXPECT_NEAR(result.quality[3].stretch_rms, std::sqrt((2 * a * a + 2 * b * b) / 8), 1e-6);
  EXPECT_EQ(result.summary.frames_with_flips, 1U);
  EXPECT_EQ(result.summary.worst_frame, 1U);
}

TEST(Carry, QualityDoesNotDependOnHeadMotion) {
  Points turned;
  for (const auto& p : corners) turned.push_back({-p.y() + 400, 100, p.x()});
  const auto result = carry_topology(square(), make_take({corners, turned}), 0);
  EXPECT_EQ(result.quality[1].flipped, 0U);
  EXPECT_NEAR(result.quality[1].stretch_rms, 0, 1e-5);
}

TEST(Carry, SampleWithoutPositionIsNamed) {
  MarkerSequence take = make_take({corners, corners});
  take.first_frame = 7;
  take.flags()[take.sample(1, 2)] = 0;
  try {
    carry_topology(square(), take, 0);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_EQ(e.details().marker, "m2");
    EXPECT_EQ(e.details().frame, 8);
  }
  take = make_take({corners, corners});
  take.position(0, 1).z() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(carry_topology(square(), take, 0), InputError);
  EXPECT_THROW(carry_topology(Topology::create(3, {{0, 1, 2}}), take, 0), InputError);
}

TEST(Carry, SameForAnyThreadCount) {
  std::vector<Points> frames;
  for (int i = 0; i < 500; ++i) frames.push_back(with_middle_at(5, 5 + 4 * std::sin(0.1 * i)));
  const MarkerSequence take = make_take(frames);
  RunContext one, three;
  three.set_threads(3);
  const auto a = carry_topology(square(), take, 0, {}, one);
  const auto b = carry_topology(square(), take, 0, {}, three);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    EXPECT_EQ(a.quality[f].stretch_rms, b.quality[f].stretch_rms);
  }
}

}  // namespace
}  // namespace kinemesh::carry_test
