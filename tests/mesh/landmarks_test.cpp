#include "mesh/landmarks.h"

#include <gtest/gtest.h>

#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::landmarks_test {
namespace {

class Landmarks : public ::testing::Test {
 protected:
  std::filesystem::path file(const std::string& name, const std::string& text) {
    write_file(folder_.path() / name, text);
    return folder_.path() / name;
  }
  test::TemporaryFolder folder_;
  test::Surface grid_ = test::plane_grid(2, 0, 1);  // 9 vertices, 8 faces
};

TEST_F(Landmarks, ListsCountFromOneInVtsAndFromZeroElsewhere) {
  EXPECT_EQ(read_vertex_list(file("a.vts", "1\n9\r\n3\n"), 9), (std::vector<VertexIndex>{0, 8, 2}));
  EXPECT_EQ(read_vertex_list(file("a.pinned", "# by hand\n0\n8\n"), 9),
            (std::vector<VertexIndex>{0, 8}));
  EXPECT_THROW(read_vertex_list(file("b.vts", "1\n0\n"), 9), InputError);
  EXPECT_THROW(read_vertex_list(file("c.txt", "1\n9\n"), 9), InputError);
  EXPECT_THROW(read_vertex_list(file("d.txt", "1 2\n"), 9), InputError);
  EXPECT_THROW(read_vertex_list(file("e.txt", "\n"), 9), InputError);
  EXPECT_THROW(read_vertex_list(file("f.vts", "nan\n"), 9), InputError);
}

TEST_F(Landmarks, PairsMayBeNamedAndLieInsideFaces) {
  const auto pairs = read_landmark_pairs(
      file("p.csv", "source,target,name\n4,8,tip of the nose\n\n0 3:0.25:0.25:0.5\n"),
      *grid_.topology, *grid_.topology);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].name, "tip of the nose");
  EXPECT_NEAR(
      (position_of(pairs[0].source, *grid_.topology, grid_.positions) - grid_.positions[4]).norm(),
      0, 1e-12);
  EXPECT_EQ(pairs[1].target.face, 3U);
  EXPECT_EQ(pairs[1].target.weights[2], 0.5);
}

TEST_F(Landmarks, WhatIsNoPointOfTheMeshIsRefusedWithItsLine) {
  for (const char* text : {"0,9", "0,-1", "0,1.5", "0", "0,8:1:0:0", "0,1:0.5:0.1:0.1",
                           "0,1:2:-1:0", "0,1:1:0", "0,1:1:0:0:0", "x y\nx y"}) {
    try {
      read_landmark_pairs(file("bad.csv", text), *grid_.topology, *grid_.topology);
      ADD_FAILURE() << text;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("line "), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace kinemesh::landmarks_test
