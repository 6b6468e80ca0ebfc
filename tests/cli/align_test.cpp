// kinemesh align as a user runs it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "config/input_file.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/bending_cylinder.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::align_test {
namespace {

using Json = nlohmann::json;

TEST(AlignCommand, TheSameCylinderAtTwoRatesAndOneThatDoesNotMove) {
  const test::TemporaryFolder folder;
  const auto place = [&](const char* name) { return (folder.path() / name).string(); };
  const auto write = [&](const char* name, const test::CylinderShape& shape) {
    write_animation(builtin_mesh_formats(), test::make_bending_cylinder(shape).mesh, place(name));
  };
  write("slow.ply", {.around = 16, .along = 40, .frames = 31, .rate_hz = 30});
  write("quick.ply", {.around = 20, .along = 50, .frames = 31, .rate_hz = 60});
  write("still.ply",
        {.around = 16, .along = 40, .frames = 31, .first_angle = 0, .second_angle = 0});
  const auto run = [&](const char* a, const char* b, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"align", place(a), place(b), "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_program(KINEMESH_PROGRAM, words);
  };
  const Json same = Json::parse(run("slow.ply", "slow.ply").out);
  EXPECT_NEAR(same["delay_s"].get<double>(), 0.0, 1e-9);
  EXPECT_NEAR(same["similarity"]["overall"].get<double>(), 1.0, 1e-9);

  const auto twice =
      run("slow.ply", "quick.ply", {"-o", place("t.csv"), "--picture", place("t.png")});
  ASSERT_EQ(twice.exit_code, 0) << twice.err;
  const Json json = Json::parse(twice.out);
  EXPECT_LT(json["difference"].get<double>(), 0.1);
  EXPECT_NEAR(json["amplitude_b_over_a"].get<double>(), 1.0, 0.1);
  const std::string csv = read_file(place("t.csv"));
  EXPECT_TRUE(csv.starts_with("a_s,b_s,moving\n0,"));
  EXPECT_EQ(std::ranges::count(csv, '\n'), 32);
  EXPECT_TRUE(read_file(place("t.png")).starts_with("\x89PNG"));

  const auto still = run("slow.ply", "still.ply");
  EXPECT_EQ(still.exit_code, 4);
  EXPECT_NE(still.err.find("nothing moves"), std::string::npos) << still.err;
}

}  // namespace
}  // namespace kinemesh::align_test
