#include "report/contact_sheet.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "config/error.h"
#include "tests/support/sanitizers.h"

namespace kinemesh::contact_sheet_test {
namespace {

using Eigen::Vector3f;

constexpr VertexIndex side = 6;

// A bent sheet that is still for 100 frames but for a bulge around frame 60; the whole turns and
// wanders, which is no motion of the surface.
AnimatedMesh bulging_sheet() {
  std::vector<Triangle> faces;
  for (VertexIndex r = 0; r + 1 < side; ++r) {
    for (VertexIndex c = 0; c + 1 < side; ++c) {
      const VertexIndex a = r * side + c;
      faces.push_back({a, a + side, a + 1});
      faces.push_back({a + 1, a + side, a + side + 1});
    }
  }
  AnimatedMesh mesh(Topology::create(side * side, faces), 100, 50.0);
  mesh.first_frame = 11;
  mesh.add_filled();
  for (std::size_t f = 0; f < 100; ++f) {
    const auto time = static_cast<float>(f);
    const float bulge = 8.0F * std::exp(-0.02F * (time - 60.0F) * (time - 60.0F));
    const Eigen::AngleAxisf turn(0.05F * time, Vector3f(1, 2, 3).normalized());
    for (VertexIndex v = 0; v < side * side; ++v) {
      const float x = 10.0F * static_cast<float>(v % side) - 25.0F;
      const float y = 25.0F - 10.0F * static_cast<float>(v / side);
      const float z = -0.02F * (x * x + y * y) + bulge * std::exp(-0.005F * (x * x + y * y));
      mesh.position(f, v) = turn * Vector3f(x, y, z) + Vector3f(3.0F * time, 0, -time);
    }
  }
  mesh.filled()[60 * side * side + 7] = 1;
  return mesh;
}

TEST(TellingFrames, AreTheFirstAndTheMostDifferent) {
  const AnimatedMesh mesh = bulging_sheet();
  const std::vector<std::size_t> two = telling_frames(mesh, 2);
  EXPECT_EQ(two, (std::vector<std::size_t>{0, 60}));
  const std::vector<std::size_t> six = telling_frames(mesh, 6);
  ASSERT_EQ(six.size(), 6U);
  EXPECT_EQ(six.front(), 0U);
  EXPECT_TRUE(std::is_sorted(six.begin(), six.end()));
  EXPECT_EQ(telling_frames(mesh, 500).size(), 100U);
}

TEST(ContactSheet, ShowsFramesWithNumbersAndTimes) {
  ContactSheetOptions options;
  options.frames = 2;
  options.title = "Subject <A>";
  const ContactSheetResult result = draw_contact_sheet(bulging_sheet(), options);
  EXPECT_EQ(result.frames, (std::vector<std::size_t>{0, 60}));
  const std::string svg = result.sheet.svg();
  EXPECT_NE(svg.find("Subject &lt;A&gt;"), std::string::npos);
  EXPECT_NE(svg.find("frame 11 · 0.00 s"), std::string::npos);
  EXPECT_NE(svg.find("frame 71 · 1.20 s"), std::string::npos);
  EXPECT_NE(svg.find(">1 filled<"), std::string::npos);
  EXPECT_NE(svg.find(">front<"), std::string::npos);

  const Image image = result.sheet.raster(1.0);
  std::size_t filled = 0;
  std::size_t surface = 0;
  for (int y = 92; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Colour c = image.colour_at(x, y);
      filled += c.r > 0.5 && c.b < 0.1 && c.g > 0.2 ? 1 : 0;
      surface += c.b > c.r && c.b < 0.9 ? 1 : 0;
    }
  }
  EXPECT_GT(filled, 10U) << "the filled vertex has its colour";
  EXPECT_GT(surface, 20000U) << "the meshes are drawn";
}

TEST(ContactSheet, SameBytesForAnyNumberOfThreads) {
  KINEMESH_LEAVE_TO_RELEASE("ShowsFramesWithNumbersAndTimes");
  RunContext one;
  RunContext two;
  one.set_threads(1);
  two.set_threads(2);
  const AnimatedMesh mesh = bulging_sheet();
  EXPECT_EQ(draw_contact_sheet(mesh, {}, one).sheet.raster().rgba,
            draw_contact_sheet(mesh, {}, two).sheet.raster().rgba);
}

TEST(ContactSheet, OddMeshes) {
  EXPECT_THROW(draw_contact_sheet(AnimatedMesh()), NoResultError);
  AnimatedMesh still(Topology::create(3, {{0, 1, 2}}), 5, 0.0);
  std::fill(still.positions().begin(), still.positions().end(), 1.0F);  // no extent, no motion
  EXPECT_EQ(draw_contact_sheet(still).frames.size(), 5U);
  AnimatedMesh holey = bulging_sheet();
  holey.position(0, 3).setConstant(NAN);
  holey.position(60, 4).setConstant(INFINITY);
  EXPECT_NO_THROW(draw_contact_sheet(holey));
  ContactSheetOptions options;
  options.frames = 0;
  EXPECT_THROW(draw_contact_sheet(still, options), UsageError);
  options = {};
  options.chosen = {4, 99, 2};
  EXPECT_EQ(draw_contact_sheet(still, options).frames, (std::vector<std::size_t>{2, 4}));
}

}  // namespace
}  // namespace kinemesh::contact_sheet_test
