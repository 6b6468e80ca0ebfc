// kinemesh info, as an operator types it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::info_test {
namespace {

using Json = nlohmann::json;
using test::TemporaryFolder;

Json info(const std::string& path, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"info", path, "--json"};
  words.insert(words.end(), more.begin(), more.end());
  const test::ProgramRun run = test::run_program(KINEMESH_PROGRAM, words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return Json::parse(run.out);
}

TEST(Info, SaysSizeTimingAndTopologyOfAnOpenSquare) {
  const TemporaryFolder folder;
  const std::string faces = "f 1 2 3\nf 1 3 4\n";
  std::ofstream(folder.path() / "s_08.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" << faces;
  std::ofstream(folder.path() / "s_09.obj") << "v 0 0 2\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" << faces;
  const Json found = info(folder.path() / "s_##.obj", {"--unit", "cm", "--rate", "50"});
  EXPECT_EQ(found["vertices"], 4);
  EXPECT_EQ(found["faces"], 2);
  EXPECT_EQ(found["edges"], 5);
  EXPECT_EQ(found["frames"], 2);
  EXPECT_EQ(found["first_frame"], 8);
  EXPECT_EQ(found["rate_hz"], 50.0);
  EXPECT_EQ(found["duration_s"], 0.04);
  EXPECT_EQ(found["unit"], "cm");
  EXPECT_EQ(found["unit_known"], false);
  EXPECT_EQ(found["box_mm"], (Json{{0.0, 0.0, 0.0}, {10.0, 10.0, 20.0}}));
  EXPECT_EQ(found["components"], 1);
  EXPECT_EQ(found["boundaries"], Json{4});
  EXPECT_EQ(found["genus"], 0);
  EXPECT_EQ(found["manifold"], true);
  EXPECT_EQ(found["worst_triangles"][0]["frame"], 9);
}

TEST(Info, ListsTheFramesOfASequenceWhoseTopologyDiffers) {
  const TemporaryFolder folder;
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  std::ofstream(folder.path() / "s_1.obj") << corners << "f 1 2 3\n";
  std::ofstream(folder.path() / "s_2.obj") << corners << "f 1 2 3\nf 1 3 4\n";
  for (const char* name : {"s_#.obj", "s_%d.obj", ""}) {
    const Json found = info(folder.path() / name);
    ASSERT_EQ(found["frames"].size(), 2U) << name;
    EXPECT_EQ(found["frames"][0]["faces"], 1);
    EXPECT_EQ(found["frames"][1]["faces"], 2);
  }
}

}  // namespace
}  // namespace kinemesh::info_test
