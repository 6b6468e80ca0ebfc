// The c3d commands as a user runs them.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "capture/c3d/writer.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::c3d_cli_test {
namespace {

using test::ProgramRun;
using test::TemporaryFolder;

ProgramRun run(const std::vector<std::string>& arguments) {
  return test::run_program(KINEMESH_PROGRAM, arguments);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A folder with a sound take (sound.c3d) and one that is cut off (cut.c3d).
class C3dCommands : public ::testing::Test {
 protected:
  C3dCommands() {
    MarkerSequence take = test::make_take(40, 12);
    test::add_analog(take, 2, 2);
    take.events = {{"Smile", "General", "", 0.125}};
    const std::string bytes = encode_c3d(take);
    write_file(sound_, bytes);
    write_file(cut_, bytes.substr(0, bytes.size() - 2000));
  }
  std::string in(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
  std::string sound_ = in("sound.c3d");
  std::string cut_ = in("cut.c3d");
};

TEST_F(C3dCommands, InfoShowsAndPrintsJson) {
  const ProgramRun text = run({"c3d", "info", sound_});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_TRUE(contains(text.out, "Points         12 markers\n")) << text.out;
  EXPECT_TRUE(contains(text.out, "Smile"));
  const ProgramRun json = run({"c3d", "info", sound_, "--json"});
  const nlohmann::json document = nlohmann::json::parse(json.out);
  EXPECT_EQ(document["points"], 12);
  EXPECT_EQ(document["frames"], 40);
  EXPECT_EQ(document["events"][0]["label"], "Smile");
  EXPECT_EQ(document["analog_channels"], 2);
}

TEST_F(C3dCommands, InfoOfWhatIsNoSessionEndsWithThree) {
  EXPECT_EQ(run({"c3d", "info", in("missing.c3d")}).exit_code, 3);
  EXPECT_EQ(run({"c3d", "info", folder_.path().string()}).exit_code, 3);
  EXPECT_EQ(run({"c3d", "info", "/dev/null"}).exit_code, 3);
  ASSERT_EQ(::mkfifo(in("fifo.c3d").c_str(), 0600), 0);
  EXPECT_EQ(run({"c3d", "info", in("fifo.c3d")}).exit_code, 3);
  write_file(in("a.csv"), "name,price\n");
  const ProgramRun table = run({"c3d", "info", in("a.csv")});
  EXPECT_EQ(table.exit_code, 3);
  EXPECT_TRUE(contains(table.err, "a.csv: line 1: this table is no session")) << table.err;
}

TEST_F(C3dCommands, CheckEndsWithThreeWhenAnyFileHasAnError) {
  EXPECT_EQ(run({"c3d", "check", sound_}).exit_code, 0);
  const ProgramRun both = run({"c3d", "check", sound_, cut_, in("missing.c3d")});
  EXPECT_EQ(both.exit_code, 3);
  EXPECT_TRUE(contains(both.out, "sound.c3d: healthy")) << both.out;
  EXPECT_TRUE(contains(both.out, "C3D302")) << both.out;
  EXPECT_TRUE(contains(both.out, "C3D001")) << both.out;
  const nlohmann::json json =
      nlohmann::json::parse(run({"c3d", "check", sound_, cut_, "--json"}).out);
  EXPECT_TRUE(json["errors"]);
  EXPECT_FALSE(json["files"][0]["errors"]);
  EXPECT_EQ(json["files"][0]["second_opinion"], "agrees");
  EXPECT_EQ(json["files"][1]["findings"][0]["code"], "C3D302");
}

TEST_F(C3dCommands, RepairWritesASoundCopyAndLeavesTheOriginal) {
  const std::string before = read_file(cut_);
  const ProgramRun repair = run({"c3d", "check", cut_, "--repair", "-o", in("new.c3d")});
  EXPECT_EQ(repair.exit_code, 0) << repair.out << repair.err;
  EXPECT_TRUE(contains(repair.out, "the complete frames were kept")) << repair.out;
  EXPECT_EQ(read_file(cut_), before);
  EXPECT_EQ(run({"c3d", "check", in("new.c3d")}).exit_code, 0);
  EXPECT_EQ(run({"c3d", "check", cut_, "--repair"}).exit_code, 2);
  EXPECT_EQ(run({"c3d", "check", cut_, "-o", in("x.c3d")}).exit_code, 2);
  EXPECT_EQ(run({"c3d", "check", cut_, sound_, "--repair", "-o", in("x.c3d")}).exit_code, 2);
  EXPECT_EQ(run({"c3d", "check", cut_, "--repair", "-o", cut_}).exit_code, 2);
  EXPECT_EQ(run({"c3d", "check", cut_, "--repair", "-o", cut_ + "/x.c3d"}).exit_code, 3);
  EXPECT_FALSE(std::filesystem::exists(in("x.c3d")));
}

TEST_F(C3dCommands, DiffInWordsAndJson) {
  const ProgramRun same = run({"c3d", "diff", sound_, sound_});
  EXPECT_EQ(same.exit_code, 0);
  EXPECT_TRUE(contains(same.out, "The two hold the same.\n"));
  const ProgramRun shorter = run({"c3d", "diff", sound_, cut_, "--json"});
  EXPECT_EQ(shorter.exit_code, 0);
  const nlohmann::json json = nlohmann::json::parse(shorter.out);
  EXPECT_FALSE(json["identical"]);
  EXPECT_EQ(json["differences"][0]["kind"], "frames");
  EXPECT_EQ(run({"c3d", "diff", sound_, cut_, "--tolerance", "-1"}).exit_code, 2);
}

TEST_F(C3dCommands, ExportsAreSessionsForEveryCommand) {
  for (const char* name : {"out.csv", "out.trc"}) {
    EXPECT_EQ(run({"c3d", "export", sound_, "-o", in(name)}).exit_code, 0);
    const ProgramRun diff =
        run({"c3d", "diff", sound_, in(name), "--no-parameters", "--tolerance", "100", "--json"});
    EXPECT_EQ(diff.exit_code, 0) << diff.err;
    const auto differences = nlohmann::json::parse(diff.out)["differences"];
    for (const auto& d : differences) {
      EXPECT_TRUE(d["kind"] == "analog" || d["kind"] == "event" || d["kind"] == "camera_mask") << d;
    }
    EXPECT_EQ(run({"c3d", "info", in(name)}).exit_code, 0);
    EXPECT_EQ(run({"c3d", "check", in(name)}).exit_code, 0);
  }
  EXPECT_TRUE(std::filesystem::exists(in("out.analog.csv")));
  EXPECT_TRUE(std::filesystem::exists(in("out.events.csv")));
  EXPECT_EQ(run({"c3d", "export", sound_, "-o", in("out.npz")}).exit_code, 0);
  EXPECT_EQ(run({"c3d", "export", sound_, "-o", in("out.json")}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(read_file(in("out.json")))["frames"], 40);
  EXPECT_EQ(run({"c3d", "export", sound_, "-o", in("out.xlsx")}).exit_code, 2);
  EXPECT_EQ(run({"c3d", "export", sound_}).exit_code, 2);
  EXPECT_EQ(run({"c3d", "export", sound_, "-o", sound_ + "/out.csv"}).exit_code, 3);
}

TEST_F(C3dCommands, CheckRunsOverAllConformanceFiles) {
  KINEMESH_NEED_DATA("c3d_conformance");
  std::vector<std::string> arguments = {"c3d", "check", "--json", "--no-second-opinion"};
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(test::data_folder() / "c3d_conformance")) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".c3d" || extension == ".C3D") arguments.push_back(entry.path().string());
  }
  const ProgramRun check = run(arguments);
  EXPECT_EQ(check.exit_code, 3);  // some of them are damaged on purpose
  const nlohmann::json json = nlohmann::json::parse(check.out);
  EXPECT_EQ(json["files"].size(), arguments.size() - 4);
  for (const auto& file : json["files"]) {
    EXPECT_TRUE(file["readable"] || contains(file["file"], "Empty.c3d")) << file["file"];
  }
}

}  // namespace
}  // namespace kinemesh::c3d_cli_test
