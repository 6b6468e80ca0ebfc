// kinemesh correspond as a user runs it.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "config/input_file.h"
#include "config/output_file.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/surface_map_io.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::correspond_test {
namespace {

class CorrespondCommand : public ::testing::Test {
 protected:
  CorrespondCommand() {
    const test::Surface box = test::bumpy(test::cube(8, 50), 2, 20);
    test::Surface larger = box;
    for (Eigen::Vector3d& p : larger.positions) p = p * 1.5 + Eigen::Vector3d(10, 0, 0);
    write("box.ply", box);
    write("larger.ply", larger);
    write("ring.ply", test::torus(12, 8, 30, 10, 0, 1));
    faces_ = box.topology->face_count();
    vertices_ = box.positions.size();
  }
  void write(const std::string& name, const test::Surface& surface) {
    AnimatedMesh mesh(surface.topology, 1, 0);
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
      mesh.position(0, v) = surface.positions[v].cast<float>();
    write_animation(builtin_mesh_formats(), mesh, place(name));
  }
  std::string place(const std::string& name) const { return (folder_.path() / name).string(); }
  int run(const std::string& arguments) {
    const std::string command = std::string(KINEMESH_PROGRAM) + " correspond " + arguments + " > " +
                                place("stdout") + " 2> " + place("stderr");
    const int status = std::system(command.c_str());
    output_ = read_file(place("stdout"));
    errors_ = read_file(place("stderr"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  test::TemporaryFolder folder_;
  std::string output_, errors_;
  std::size_t faces_ = 0, vertices_ = 0;
};

TEST_F(CorrespondCommand, WritesBothDirectionsAndNamesThem) {
  const std::string files = place("box.ply") + " " + place("larger.ply");
  ASSERT_EQ(run(files + " -o " + place("map.csv") + " --reverse " + place("back.json") + " --json"),
            0)
      << errors_;
  const SurfaceMap map = read_surface_map(place("map.csv"));
  const SurfaceMap back = read_surface_map(place("back.json"));
  EXPECT_EQ(map.source_name, place("box.ply"));
  EXPECT_EQ(map.target_name, place("larger.ply"));
  EXPECT_EQ(back.source_name, map.target_name);
  ASSERT_EQ(map.points.size(), vertices_);
  ASSERT_EQ(map.confidence.size(), vertices_);
  for (const SurfacePoint& p : map.points) EXPECT_LT(p.face, faces_);
  const nlohmann::json json = nlohmann::json::parse(output_);
  EXPECT_EQ(json["unmapped_source"], 0);
  EXPECT_EQ(json["poor"], false);
}

TEST_F(CorrespondCommand, MeetsLandmarksGivenByHand) {
  write_file(place("pairs.csv"), "source,target,name\n0,0,corner\n40,40\n100,3:0.2:0.3:0.5\n");
  const std::string files = place("box.ply") + " " + place("larger.ply") + " -o " + place("m.csv");
  ASSERT_EQ(run(files + " --landmarks " + place("pairs.csv")), 0) << errors_;
  const SurfaceMap map = read_surface_map(place("m.csv"));
  EXPECT_EQ(map.points[100].face, 3U);
  EXPECT_NEAR(map.points[100].weights[2], 0.5, 1e-12);
  write_file(place("pairs.csv"), "0,0,corner\n0,1,edge\n");
  EXPECT_EQ(run(files + " --landmarks " + place("pairs.csv")), 4);
  EXPECT_NE(errors_.find("1 (corner) and 2 (edge)"), std::string::npos) << errors_;
}

TEST_F(CorrespondCommand, RefusesWhatHasNoMapAndSaysWhy) {
  EXPECT_EQ(run(place("box.ply") + " " + place("ring.ply") + " -o " + place("map.csv")), 4);
  EXPECT_NE(errors_.find("the target: the surface has 1 handle"), std::string::npos) << errors_;
  EXPECT_FALSE(std::filesystem::exists(place("map.csv")));
  EXPECT_EQ(run(place("box.ply") + " " + place("none.ply") + " -o " + place("map.csv")), 3);
  EXPECT_EQ(run(place("box.ply") + " " + place("larger.ply") + " -o " + place("map.txt")), 2);
}

}  // namespace
}  // namespace kinemesh::correspond_test
