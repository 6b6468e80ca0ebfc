// kinemesh c3d process and c3d quality, and convert --edits, as a user runs them.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/c3d/reader.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "tests/support/data.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::process_test {
namespace {

namespace fs = std::filesystem;

class Process : public ::testing::Test {
 protected:
  std::string in(const std::string& name) const { return (folder_.path() / name).string(); }
  static test::ProgramRun run(const std::vector<std::string>& arguments) {
    return test::run_program(KINEMESH_PROGRAM, arguments);
  }
  test::TemporaryFolder folder_;
  std::string session_ = (test::sample_folder() / "ben_surprise.c3d").string();
};

TEST_F(Process, CleansAndItsListGivesTheSameBytes) {
  const auto first = run({"c3d", "process", session_, "-o", in("a.c3d"), "--picture"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_NE(first.out.find("RMOU06"), std::string::npos) << first.out;
  EXPECT_TRUE(fs::exists(in("a.c3d.png")));
  const auto second =
      run({"c3d", "process", session_, "-o", in("b.c3d"), "--edits", in("a.c3d.edits.toml")});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(read_file(in("a.c3d")), read_file(in("b.c3d")));
  // What was only written may be replaced, what somebody changed may not.
  EXPECT_EQ(run({"c3d", "process", session_, "-o", in("a.c3d")}).exit_code, 0);
  std::ofstream(in("a.c3d.edits.toml"), std::ios::app) << "\n# mine\n";
  const auto third = run({"c3d", "process", session_, "-o", in("a.c3d")});
  EXPECT_NE(third.exit_code, 0);
  EXPECT_NE(third.err.find("--record"), std::string::npos) << third.err;
  const MarkerSequence before = read_c3d(session_).take;
  const MarkerSequence after = read_c3d(in("a.c3d")).take;
  EXPECT_EQ(after.markers(), before.markers());
  EXPECT_EQ(after.events, before.events);
  for (std::size_t f = 0; f < after.frame_count(); ++f) {
    for (std::size_t m = 0; m < after.marker_count(); ++m) ASSERT_TRUE(after.valid(f, m));
  }
}

TEST_F(Process, WritesTablesAndConvertTakesTheList) {
  write_file(in("list.toml"),
             "[[edit]]\ndo = \"crop\"\nfrom = 50\nto = 149\n[[edit]]\ndo = \"repair\"\n");
  for (const char* name : {"out.trc", "out.csv"}) {
    const auto done = run({"c3d", "process", session_, "-o", in(name), "--edits", in("list.toml")});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_GT(fs::file_size(in(name)), 10000U);
  }
  const auto mesh = run({"convert", session_, "-o", in("face.ply"), "--edits", in("list.toml"),
                         "--no-pictures", "--no-report", "--json"});
  ASSERT_EQ(mesh.exit_code, 0) << mesh.err;
  EXPECT_NE(mesh.out.find("100"), std::string::npos);
}

TEST_F(Process, SaysWhatIsWrong) {
  write_file(in("list.toml"), "[[edit]]\ndo = \"crop\"\nbegin = 50\n");
  const auto wrong =
      run({"c3d", "process", session_, "-o", in("x.c3d"), "--edits", in("list.toml")});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("line 3"), std::string::npos) << wrong.err;
  EXPECT_FALSE(fs::exists(in("x.c3d")));
  const auto unknown = run({"c3d", "process", session_, "-o", in("x.dat")});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find(".c3d, .csv"), std::string::npos) << unknown.err;
  const auto missing =
      run({"c3d", "process", session_, "-o", in("x.c3d"), "--template", in("none.c3d")});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_NE(missing.err.find("none.c3d"), std::string::npos) << missing.err;
  fs::copy_file(session_, in("same.c3d"));
  EXPECT_EQ(run({"c3d", "process", in("same.c3d"), "-o", in("same.c3d")}).exit_code, 2);
}

TEST_F(Process, NothingThatIsReadIsReplacedByAnyOutput) {
  fs::copy_file(session_, in("take.c3d"));
  fs::copy_file(session_, in("second.c3d"));
  write_file(in("join.toml"), "[[edit]]\ndo = \"join\"\nfile = \"second.c3d\"\n");
  const std::string before = read_file(in("take.c3d"));
  const std::vector<std::vector<std::string>> attempts{
      {"c3d", "process", in("take.c3d"), "-o", in("o.c3d"), "--record", in("take.c3d")},
      {"c3d", "process", in("take.c3d"), "-o", in("o.c3d"), "--record", in("o.c3d")},
      {"c3d", "process", in("take.c3d"), "-o", in("second.c3d"), "--template", in("second.c3d")},
      {"c3d", "process", in("take.c3d"), "-o", in("second.c3d"), "--edits", in("join.toml")},
      {"c3d", "quality", in("take.c3d"), "--picture", in("take.c3d")}};
  for (const std::vector<std::string>& attempt : attempts) {
    const auto refused = run(attempt);
    EXPECT_EQ(refused.exit_code, 2) << refused.out << refused.err;
  }
  EXPECT_EQ(read_file(in("take.c3d")), before);
  EXPECT_EQ(read_file(in("second.c3d")), before);
  EXPECT_FALSE(fs::exists(in("o.c3d")));
}

TEST_F(Process, QualityGivesALineJsonAndAPicture) {
  const auto text = run({"c3d", "quality", session_, "--picture", in("q.png")});
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_EQ(text.out.find("verdict       fit after cleaning: 1 label swap"), 0U) << text.out;
  EXPECT_GT(fs::file_size(in("q.png")), 10000U);
  const auto json = nlohmann::json::parse(run({"c3d", "quality", session_, "--json"}).out);
  EXPECT_EQ(json["verdict"], "fit after cleaning");
  EXPECT_EQ(json["swaps"][0]["from_frame"], 244);
  EXPECT_EQ(json["head"]["rigid_markers"].is_array(), true);
}

}  // namespace
}  // namespace kinemesh::process_test
