// kinemesh match as a user runs it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "analysis/feature_io.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/bending_cylinder.h"
#include "tests/support/command_test.h"

namespace kinemesh::match_test {
namespace {

class MatchCommand : public test::CommandTest {
 protected:
  MatchCommand() : CommandTest(KINEMESH_PROGRAM " match") {
    const test::BendingCylinder cylinder =
        test::make_bending_cylinder({.around = 16, .along = 40, .frames = 20});
    write_animation(builtin_mesh_formats(), cylinder.mesh, place("a.ply"));
    FeatureSet set{.animation = "a.ply",
                   .vertex_count = cylinder.mesh.vertex_count(),
                   .frame_count = 20,
                   .rate_hz = 30,
                   .features = {}};
    for (const uint32_t v : {5U, 150U, 260U, 330U, 470U, 600U}) {
      const uint32_t frame = v / 40;
      set.features.push_back({.vertex = v, .frame = frame, .time_s = frame / 30.0});
    }
    write_features(place("a.json"), set);
    set.features.clear();
    write_features(place("none.json"), set);
  }
};

TEST_F(MatchCommand, MatchesPictureAndTerms) {
  const std::string files = place("a.json") + " " + place("a.json");
  ASSERT_EQ(run(files + " " + place("a.ply") + " " + place("a.ply") + " -o " + place("m.json") +
                " --picture " + place("m.png") + " --json"),
            0);
  const nlohmann::json json = nlohmann::json::parse(read_file(place("m.json")));
  EXPECT_EQ(json, nlohmann::json::parse(output_));
  ASSERT_EQ(json["matches"].size(), 6U);
  for (const auto& m : json["matches"]) EXPECT_EQ(m["source"], m["target"]);
  EXPECT_TRUE(json["certified"].get<bool>());  // though the energy is nought
  EXPECT_TRUE(read_file(place("m.png")).starts_with("\x89PNG"));
  // The animations that the features name, and the other format.
  ASSERT_EQ(run(files + " -o " + place("m.csv")), 0);
  EXPECT_TRUE(read_file(place("m.csv")).starts_with("source,target,source_vertex,"));
}

TEST_F(MatchCommand, MistakesHaveTheirExitCode) {
  const std::string meshes = " " + place("a.ply") + " " + place("a.ply");
  EXPECT_EQ(run(place("none.json") + " " + place("a.json") + meshes + " -o " + place("m.json")), 0);
  EXPECT_NE(output_.find("no match"), std::string::npos);
  EXPECT_EQ(run(place("a.ply") + " " + place("a.json") + meshes + " -o " + place("m.json")), 3);
  EXPECT_EQ(run(place("a.json") + " " + place("a.json") + meshes + " -o " + place("m.txt")), 2);
  EXPECT_EQ(run(place("a.json") + " " + place("a.json")), 2);
  EXPECT_EQ(run(place("a.json") + " " + place("a.json") + meshes + " -o " + place("m.json") +
                " --picture " + place("m.bmp")),
            2);
  EXPECT_EQ(run(place("missing.json") + " " + place("a.json") + meshes + " -o " + place("m.txt")),
            2);  // before anything is read
  EXPECT_EQ(run(place("a.json") + " " + place("a.json") + meshes + " -o " + place("a.json")), 2);
  std::filesystem::remove(place("m.json"));
  EXPECT_EQ(run(place("a.json") + " " + place("a.json") + meshes + " -o " + place("m.json") +
                " --picture /proc/m.png"),
            3);
  EXPECT_FALSE(std::filesystem::exists(place("m.json")));  // all files or none
}

}  // namespace
}  // namespace kinemesh::match_test
