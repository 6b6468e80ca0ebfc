// kinemesh geodesics as a user runs it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "mesh/formats/mesh_io.h"
#include "mesh/formats/npz.h"
#include "tests/support/command_test.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::geodesics_command_test {
namespace {

class GeodesicsCommand : public test::CommandTest {
 protected:
  GeodesicsCommand() : CommandTest(KINEMESH_PROGRAM " geodesics") {
    write_mesh(builtin_mesh_formats(), test::plane_grid(4, 0.0, 0).mesh(), place("plane.ply"));
  }
};

TEST_F(GeodesicsCommand, DistancesAndPathsAsCsv) {
  ASSERT_EQ(run(place("plane.ply") + " --from 0 --to 23 -o " + place("d.csv") + " --json"), 0);
  std::istringstream lines(read_file(place("d.csv")));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "vertex,distance");
  for (int v = 0; v < 25; ++v) {
    ASSERT_TRUE(std::getline(lines, line));
    double distance = 0.0;
    int vertex = -1;
    ASSERT_EQ(std::sscanf(line.c_str(), "%d,%lf", &vertex, &distance), 2);
    EXPECT_EQ(vertex, v);
    EXPECT_NEAR(distance, std::hypot(v % 5, v / 5), 1e-12);
  }
  EXPECT_TRUE(read_file(place("d_path.csv")).starts_with("path,x,y,z,face,b0,b1,b2\n0,0,0,0,"));
  const nlohmann::json json = nlohmann::json::parse(output_);
  EXPECT_NEAR(json["targets"][0]["distance_mm"].get<double>(), 5.0, 1e-12);
}

TEST_F(GeodesicsCommand, EveryMethodAndOutput) {
  EXPECT_EQ(run(place("plane.ply") + " --from 0 6 --method dijkstra -o " + place("d.npz")), 0);
  EXPECT_EQ(npz_array(read_npz(place("d.npz")), "distances").size(), 25U);
  EXPECT_EQ(run(place("plane.ply") + " --from 0:0.2:0.3:0.5 --method heat -o " + place("d.ply")),
            0);
  EXPECT_EQ(read_mesh(builtin_mesh_formats(), place("d.ply")).positions.size(), 25U);
  EXPECT_EQ(run(place("plane.ply") + " --from 0,6 --to 24 -o " + place("d.png")), 0);
  EXPECT_TRUE(read_file(place("d.png")).starts_with("\x89PNG"));
}

TEST_F(GeodesicsCommand, TargetsOnOtherPiecesHaveNoPath) {
  std::ofstream(place("two.off")) << "OFF\n7 2 0\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n6 5 5\n5 6 5\n"
                                     "9 9 9\n3 0 1 2\n3 3 4 5\n";
  for (const std::string output : {"d.csv", "d.npz", "d.ply", "d.png"}) {
    ASSERT_EQ(run(place("two.off") + " --from 0 --to 4 1 -o " + place(output) + " --json"), 0);
    const nlohmann::json json = nlohmann::json::parse(output_);
    EXPECT_TRUE(json["targets"][0]["distance_mm"].is_null());
    EXPECT_EQ(json["targets"][1]["distance_mm"], 1.0);
  }
  EXPECT_NE(read_file(place("d.csv")).find("\n4,inf\n"), std::string::npos);
  EXPECT_TRUE(read_file(place("d_path.csv")).starts_with("path,x,y,z,face,b0,b1,b2\n1,0,0,0,"));
  EXPECT_EQ(npz_array(read_npz(place("d.npz")), "path_starts").size(), 2U);
  EXPECT_EQ(run(place("two.off") + " --from 6 -o " + place("d.csv")), 2);  // in no face
  EXPECT_NE(errors_.find("7 vertices and 2 faces"), std::string::npos) << errors_;
}

TEST_F(GeodesicsCommand, MistakesHaveTheirExitCodeAndLeaveNothing) {
  const std::size_t before =
      (run(place("plane.ply") + " --from 99 -o " + place("d.csv")), folder_.entry_count());
  EXPECT_EQ(run(place("plane.ply") + " --from 99 -o " + place("d.csv")), 2);
  EXPECT_EQ(run(place("plane.ply") + " --from x -o " + place("d.csv")), 2);
  EXPECT_EQ(run(place("plane.ply") + " --from 0 -o " + place("d.txt")), 2);
  EXPECT_EQ(run(place("plane.ply") + " -o " + place("d.csv")), 2);
  EXPECT_EQ(run(place("missing.ply") + " --from 0 -o " + place("d.csv")), 3);
  EXPECT_EQ(run(place("missing.ply") + " --from 0 -o " + place("d.txt")), 2);  // before reading
  const std::string mesh = read_file(place("plane.ply"));
  EXPECT_EQ(run(place("plane.ply") + " --from 0 -o " + place("plane.ply")), 2);
  EXPECT_EQ(read_file(place("plane.ply")), mesh);  // inputs are never replaced
  EXPECT_EQ(folder_.entry_count(), before);
}

}  // namespace
}  // namespace kinemesh::geodesics_command_test
