// kinemesh features, evaluate features and deformation as a user runs them.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "analysis/feature_io.h"
#include "config/output_file.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/surface_map_io.h"
#include "tests/support/command_test.h"
#include "tests/support/deforming_shapes.h"

namespace kinemesh::features_command_test {
namespace {

using nlohmann::json;

class FeaturesCommand : public test::CommandTest {
 protected:
  FeaturesCommand() : CommandTest(KINEMESH_PROGRAM), sheet_(test::make_sheet(60, 60, 4, 1)) {}

  std::string write(const std::string& name, const AnimatedMesh& mesh) {
    write_animation(builtin_mesh_formats(), mesh, place(name));
    return place(name);
  }
  AnimatedMesh bump() const { return test::bumps(sheet_, {{{22, 30}, 9, 0.5, 0.1, 8}}, 1, 20); }
  AnimatedMesh still(std::size_t frames) const {
    return test::animate(sheet_.topology,
                         std::vector<std::vector<Eigen::Vector3d>>(frames, sheet_.positions), 20);
  }
  int find(const std::string& animation) {
    return run("features " + animation + " -o " + place("f.json"));
  }

  test::Sheet sheet_;
};

TEST_F(FeaturesCommand, WritesFeaturesTableAndPicture) {
  const std::string animation = write("a.ply", bump());
  ASSERT_EQ(run("features " + animation + " -o " + place("f.json") + " --csv --picture --json"), 0)
      << errors_;
  const json summary = json::parse(output_), file = json::parse(read_file(place("f.json")));
  ASSERT_FALSE(file["features"].empty());
  EXPECT_GE(summary["features"].get<int>(), 1);
  const json& f = file["features"][0];
  for (const char* key : {"vertex", "frame", "time_s", "sigma_mm", "tau_s", "response", "kind"}) {
    EXPECT_TRUE(f.contains(key)) << key;
  }
  EXPECT_NEAR(f["time_s"].get<double>(), 0.5, 0.1);
  EXPECT_TRUE(read_file(place("f.png")).starts_with("\x89PNG"));
  EXPECT_TRUE(read_file(place("f.csv")).starts_with("vertex,frame,"));
}

TEST_F(FeaturesCommand, EvaluatesAgainstATruthAndPaintedRegions) {
  const std::string animation = write("a.ply", bump());
  ASSERT_EQ(find(animation), 0);
  SurfaceMap same;
  for (VertexIndex v = 0; v < sheet_.positions.size(); ++v) {
    same.points.push_back(vertex_point(*sheet_.topology, v));
  }
  write_surface_map(place("map.csv"), same);
  const std::string features = place("f.json");
  ASSERT_EQ(run("evaluate features " + features + " " + features + " --truth " + place("map.csv") +
                " --curve " + place("curve.png") + " --json"),
            0)
      << errors_;
  const json result = json::parse(output_);
  for (const char* measure : {"strict", "strict_with_slack", "nearest"}) {
    EXPECT_EQ(result["features"][measure], 1.0);
    EXPECT_LT(result["random_vertices"][measure], 1.0);
  }
  EXPECT_TRUE(read_file(place("curve.png")).starts_with("\x89PNG"));
  // One volunteer painted the feature's own vertex.
  const auto vertex = read_features(features).features[0].vertex;
  write_file(place("anna.json"), "{\"regions\": [[" + std::to_string(vertex) + "]]}");
  ASSERT_EQ(run("evaluate features " + features + " --regions " + place("anna.json") + " --json"),
            0)
      << errors_;
  const json scores = json::parse(output_);
  ASSERT_EQ(scores.size(), 1U);
  EXPECT_EQ(scores[0]["recall"], 1.0);
  EXPECT_LT(scores[0]["precision"], 1.0);
  EXPECT_EQ(run("evaluate features " + features), 2);
  EXPECT_EQ(run("evaluate features " + features + " --regions " + place("a.ply")), 3);
}

TEST_F(FeaturesCommand, NothingToFindIsAnEmptyResultThatSaysWhy) {
  ASSERT_EQ(find(write("one.ply", still(1))), 0) << errors_;
  EXPECT_NE(output_.find("1 frame"), std::string::npos) << output_;
  ASSERT_EQ(find(write("still.ply", still(8))), 0) << errors_;
  EXPECT_NE(output_.find("nothing deforms"), std::string::npos) << output_;
  EXPECT_EQ(run("deformation " + place("one.ply") + " -o " + place("d.csv")), 0) << errors_;
}

TEST_F(FeaturesCommand, BrokenMeshesAreMeasuredAndJumpsSurvived) {
  // A triangle on a line, a third triangle on an edge, a vertex without faces; one frame jumps.
  auto faces = sheet_.topology->faces();
  const AnimatedMesh good = bump();
  const auto count = static_cast<VertexIndex>(good.vertex_count());
  faces.push_back({0, 1, 2});
  faces.push_back({faces[0][0], faces[0][1], count});
  AnimatedMesh broken(Topology::create(count + 2, faces), good.frame_count(), 20);
  for (std::size_t f = 0; f < good.frame_count(); ++f) {
    for (VertexIndex v = 0; v < count; ++v) broken.position(f, v) = good.position(f, v);
    broken.position(f, count) = Eigen::Vector3f(5, 5, 20);
    broken.position(f, count + 1) = Eigen::Vector3f(90, 90, 0);
  }
  for (VertexIndex v = 0; v < count; ++v) broken.position(4, v) *= 50.0F;
  ASSERT_EQ(find(write("broken.ply", broken)), 0) << errors_;
  EXPECT_NE(errors_.find("jumps to frames 4 and 5"), std::string::npos) << errors_;
  EXPECT_NE(output_.find("1 triangle without area"), std::string::npos) << output_;
  for (const Feature& f : read_features(place("f.json")).features) {
    EXPECT_TRUE(std::isfinite(f.response));
    EXPECT_NE(f.vertex, count + 1);
  }
}

TEST_F(FeaturesCommand, AnOutputThatIsNoJsonIsRefused) {
  EXPECT_EQ(run("features " + place("none.ply") + " -o " + place("f.xyz")), 2);
  EXPECT_NE(errors_.find(".json"), std::string::npos) << errors_;
}

TEST_F(FeaturesCommand, PositionsThatAreNoNumbersAreRefusedByPlace) {
  const std::string animation = write("nan.ply", bump());
  std::string samples = read_file(place("nan.pc2"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  samples.replace(samples.size() - 4, 4, reinterpret_cast<const char*>(&nan), 4);
  write_file(place("nan.pc2"), samples);
  EXPECT_EQ(find(animation), 3);
  EXPECT_NE(errors_.find("vertex"), std::string::npos) << errors_;
  EXPECT_NE(errors_.find("frame"), std::string::npos) << errors_;
  EXPECT_EQ(run("deformation " + animation + " -o " + place("d.npz")), 3);
}

}  // namespace
}  // namespace kinemesh::features_command_test
