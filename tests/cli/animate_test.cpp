// kinemesh animate, basis, express and retarget as a user runs them, one after the other.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "config/input_file.h"
#include "config/output_file.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/surface_map_io.h"
#include "tests/support/data.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::animate_test {
namespace {

namespace fs = std::filesystem;

SurfaceMap identity_map(const Topology& topology) {
  SurfaceMap map;
  map.points.resize(topology.vertex_count());
  for (FaceIndex f = 0; f < topology.face_count(); ++f) {
    for (std::size_t c = 0; c < 3; ++c) {
      SurfacePoint p{f, {0.0, 0.0, 0.0}};
      p.weights.at(c) = 1.0;
      map.points[topology.faces()[f].at(c)] = p;
    }
  }
  return map;
}

TEST(AnimateCommand, ASampleDrivesItsScanAndIsDescribedAndTransferred) {
  const test::TemporaryFolder folder;
  const auto place = [&](const char* name) { return (folder.path() / name).string(); };
  const std::string scan = (test::sample_folder() / "truth" / "anna_rest.ply").string();
  const std::string session = (test::sample_folder() / "anna_happy.c3d").string();
  const auto run = [&](std::vector<std::string> words) {
    const test::ProgramRun done = test::run_program(KINEMESH_PROGRAM, words);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return nlohmann::json::parse(done.out.empty() ? "{}" : done.out);
  };
  const auto animated = run({"animate", scan, session, "-o", place("happy.ply"), "--fill", "cubic",
                             "--frames", "1:420:20", "--no-pictures", "--json"});
  EXPECT_EQ(animated["markers"], 167);
  EXPECT_LT(animated["registration_rms_mm"], 0.5);
  EXPECT_EQ(animated["marker_distances"].size(), 167U);
  for (const auto& path : animated["outputs"]) EXPECT_TRUE(fs::exists(path.get<std::string>()));
  const auto basis = run({"basis", place("happy.ply"), "-o", place("basis.npz"), "--json"});
  EXPECT_LE(basis["rms_error_mm"], 0.1);
  const auto scores =
      run({"express", place("basis.npz"), place("happy.ply"), "-o", place("scores.csv"), "--json"});
  EXPECT_EQ(scores["frames"], 21);
  EXPECT_LE(scores["rms_error_mm"], 0.11);
  const AnimatedMesh happy = read_animation(builtin_mesh_formats(), place("happy.ply"));
  write_surface_map(place("map.csv"), identity_map(happy.topology()));
  run({"retarget", place("happy.ply"), scan, scan, "--map", place("map.csv"), "-o",
       place("again.ply"), "--json"});
  const AnimatedMesh again = read_animation(builtin_mesh_formats(), place("again.ply"));
  ASSERT_EQ(again.positions().size(), happy.positions().size());
  for (std::size_t i = 0; i < again.positions().size(); i += 97) {
    ASSERT_NEAR(again.positions()[i], happy.positions()[i], 0.01F) << i;
  }
}

TEST(AnimateCommand, WrongInputsEndWithAMessageAndNoFile) {
  const test::TemporaryFolder folder;
  const std::string session = (test::sample_folder() / "anna_happy.c3d").string();
  const std::string out = (folder.path() / "out.ply").string();
  const auto missing =
      test::run_program(KINEMESH_PROGRAM, {"animate", "nowhere.ply", session, "-o", out});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_NE(missing.err.find("nowhere.ply"), std::string::npos);
  const std::string cloud = (folder.path() / "cloud.ply").string();
  write_file(cloud,
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
             "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n");
  const auto points = test::run_program(KINEMESH_PROGRAM, {"animate", cloud, session, "-o", out});
  EXPECT_NE(points.exit_code, 0);
  EXPECT_FALSE(points.err.empty());
  EXPECT_FALSE(fs::exists(out));
}

/// As a user mistypes it: the scan, the other subject or the basis named as output, too.
TEST(AnimateCommand, NoCommandReplacesWhatItReads) {
  const test::TemporaryFolder folder;
  const auto copied = [&](const fs::path& from, const char* name) {
    fs::copy_file(from, folder.path() / name);
    return (folder.path() / name).string();
  };
  const std::string scan = copied(test::sample_folder() / "truth" / "anna_rest.ply", "anna.ply");
  const std::string other = copied(test::sample_folder() / "truth" / "ben_rest.ply", "ben.ply");
  const std::string session = copied(test::sample_folder() / "anna_happy.c3d", "anna.c3d");
  const std::string before = read_file(scan);
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"animate", scan, session, "-o", scan},
           {"retarget", scan, scan, other, "--map", session, "-o", other},
           {"basis", scan, "-o", scan},
           {"express", session, scan, "-o", scan}}) {
    const auto run = test::run_program(KINEMESH_PROGRAM, words);
    EXPECT_EQ(run.exit_code, 2) << words.front() << run.err;
    EXPECT_NE(run.err.find("replace the input"), std::string::npos) << words.front() << run.err;
  }
  EXPECT_EQ(read_file(scan), before);
}

}  // namespace
}  // namespace kinemesh::animate_test
