// kinemesh batch, as an operator types it.
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "config/input_file.h"
#include "config/output_file.h"
#include "tests/support/data.h"
#include "tests/support/run_program.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::batch_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::TemporaryFolder;

test::ProgramRun batch(std::vector<std::string> more, double interrupt_after_s = -1.0) {
  std::vector<std::string> words{"batch"};
  words.insert(words.end(), more.begin(), more.end());
  return test::run_program(KINEMESH_PROGRAM, words, interrupt_after_s);
}

std::string outcome(const Json& result, std::size_t i) {
  return result["sessions"][i]["outcome"].get<std::string>();
}

/// Two good sessions that share a topology, one that is missing and one that is none.
fs::path study_in(const TemporaryFolder& folder) {
  for (const char* name : {"anna_happy.c3d", "anna_surprise.c3d"}) {
    fs::copy_file(test::sample_folder() / name, folder.path() / name);
  }
  write_file(folder.path() / "broken.c3d", "this is no session");
  write_file(folder.path() / "study.toml",
             "output = \"out\"\n[options.pictures]\npictures = false\nreport = false\n"
             "[options.gaps]\nfill = \"linear\"\nmax-gap = 60\n"
             "[[session]]\nsession = \"anna_surprise.c3d\"\ntopology = \"anna_happy.ply\"\n"
             "[[session]]\nsession = \"broken.c3d\"\n"
             "[[session]]\nsession = \"missing.c3d\"\n"
             "[[session]]\nsession = \"anna_happy.c3d\"\n");
  return folder.path() / "study.toml";
}

TEST(Batch, OneThatFailsHarmsNoOtherAndResumeLeavesOutWhatIsFinished) {
  const TemporaryFolder folder;
  const std::string study = study_in(folder).string();
  const test::ProgramRun plan = batch({study, "--dry-run", "--json"});
  EXPECT_EQ(plan.exit_code, 3);  // one is missing
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
  EXPECT_EQ(outcome(Json::parse(plan.out), 0), "not begun");
  EXPECT_EQ(outcome(Json::parse(plan.out), 2), "failed");

  const test::ProgramRun first = batch({study, "--json", "--jobs", "2"});
  EXPECT_EQ(first.exit_code, 3) << first.err;
  const Json result = Json::parse(first.out);
  EXPECT_EQ(outcome(result, 0), "done") << first.out;
  EXPECT_EQ(outcome(result, 1), "failed");
  EXPECT_EQ(outcome(result, 2), "failed");
  EXPECT_EQ(outcome(result, 3), "done");
  EXPECT_EQ(result["sessions"][0]["vertices"], result["sessions"][3]["vertices"]);
  const auto reason = result["sessions"][1]["reason"].get<std::string>();
  EXPECT_FALSE(reason.empty());
  EXPECT_EQ(reason.find("broken.c3d"), std::string::npos) << reason;
  EXPECT_EQ(Json::parse(read_file(folder.path() / "out/study_outcomes.json")), result);
  const std::string mesh = read_file(folder.path() / "out/anna_surprise.ply");

  const Json again = Json::parse(batch({study, "--json", "--resume"}).out);
  EXPECT_EQ(outcome(again, 0), "finished before");
  EXPECT_EQ(outcome(again, 1), "failed");
  EXPECT_EQ(outcome(again, 3), "finished before");
  // From wherever it is run: relative paths name the same files.
  const fs::path relative = fs::proximate(study);
  const Json elsewhere = Json::parse(batch({relative.string(), "--json", "--resume"}).out);
  EXPECT_EQ(outcome(elsewhere, 3), "finished before");
  for (const Json& file : elsewhere["sessions"][3]["files"]) {
    EXPECT_TRUE(fs::exists(file.get<std::string>())) << file;
  }

  // What is gone or was made with other options is made again.
  fs::remove(folder.path() / "out/anna_surprise.pc2");
  const Json made = Json::parse(batch({study, "--json", "--resume"}).out);
  EXPECT_EQ(outcome(made, 0), "done");
  EXPECT_EQ(outcome(made, 3), "finished before");
  EXPECT_EQ(read_file(folder.path() / "out/anna_surprise.ply"), mesh);
  const Json other =
      Json::parse(batch({study, "--json", "--resume", "--dry-run", "--max-gap", "0.1"}).out);
  EXPECT_EQ(outcome(other, 3), "not begun");
}

TEST(Batch, CtrlCStopsItAndResumeGoesOn) {
  const TemporaryFolder folder;
  const std::string study = study_in(folder).string();
  // The careful way to fill takes long enough to be stopped.
  const test::ProgramRun stopped =
      batch({study, "--json", "--jobs", "1", "--fill", "auto", "--effort", "full"}, 0.15);
  ASSERT_EQ(stopped.exit_code, 130);
  // On a slow machine it is stopped before it made its folder.
  fs::create_directories(folder.path() / "out");
  for (const auto& entry : fs::recursive_directory_iterator(folder.path() / "out")) {
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }
  const Json resumed = Json::parse(batch({study, "--json", "--resume"}).out);
  EXPECT_NE(outcome(resumed, 0), "cancelled");
  EXPECT_TRUE(fs::exists(folder.path() / "out/anna_surprise.ply"));
}

TEST(Batch, AMissingFrameOfANumberedMeshIsNoticed) {
  const TemporaryFolder folder;
  const std::string study = study_in(folder).string();
  write_file(study,
             "output = \"out\"\nextension = \".pvd\"\n[options.pictures]\npictures = false\n"
             "report = false\n[options.gaps]\nfill = \"linear\"\nmax-gap = 60\n"
             "[options.write]\nframes = \"11:20\"\n"
             "[[session]]\nsession = \"anna_happy.c3d\"\n");
  EXPECT_EQ(outcome(Json::parse(batch({study, "--json"}).out), 0), "done");
  EXPECT_EQ(outcome(Json::parse(batch({study, "--json", "--resume"}).out), 0), "finished before");
  std::vector<fs::path> frames;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path() / "out")) {
    if (entry.path().extension() == ".vtp") frames.push_back(entry.path());
  }
  ASSERT_EQ(frames.size(), 10U);
  fs::remove(folder.path() / "out/anna_happy_frames" / frames[4].filename());
  EXPECT_EQ(outcome(Json::parse(batch({study, "--json", "--resume"}).out), 0), "done");
  EXPECT_TRUE(fs::exists(frames[4]));
}

/// Ends a batch of one session after the other by SIGKILL, as a power cut would, as soon as its
/// first session is noted.
void kill_after_the_first(const std::string& study, const fs::path& journal) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl(KINEMESH_PROGRAM, KINEMESH_PROGRAM, "batch", study.c_str(), "--jobs", "1", "-q",
            nullptr);
    std::_Exit(127);
  }
  for (int waited = 0; waited < 6000; ++waited) {
    std::error_code none;
    if (fs::exists(journal, none) && fs::file_size(journal, none) > 2) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(60));  // the next one is under way
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << "it came to its end before";
}

TEST(Batch, AfterAPowerCutItGoesOnWhereItWas) {
  KINEMESH_LEAVE_TO_RELEASE("CtrlCStopsItAndResumeGoesOn");
  const TemporaryFolder folder;
  const std::string study = study_in(folder).string();
  // The second takes long enough to be cut off: it is filled the careful way.
  fs::copy_file(test::sample_folder() / "ben_happy.c3d", folder.path() / "ben_happy.c3d");
  write_file(study,
             "output = \"out\"\n[options.pictures]\npictures = false\nreport = false\n"
             "[options.gaps]\neffort = \"full\"\n"
             "[[session]]\nsession = \"anna_happy.c3d\"\n"
             "[[session]]\nsession = \"ben_happy.c3d\"\n");
  const fs::path out = folder.path() / "out";
  kill_after_the_first(study, out / "study.journal");
  const std::string first = read_file(out / "anna_happy.pc2");
  const auto made = fs::last_write_time(out / "anna_happy.pc2");
  EXPECT_FALSE(fs::exists(out / "ben_happy.pc2"));
  // What the cut may leave: a temporary file, and a line of the journal that breaks off.
  write_file(out / ".ben_happy.pc2.999999999-0.tmp", "half");
  std::ofstream(out / "study.journal", std::ios::app) << "{\"output\":\"ben_ha";

  const Json resumed = Json::parse(batch({study, "--json", "--resume"}).out);
  EXPECT_EQ(outcome(resumed, 0), "finished before");
  EXPECT_EQ(outcome(resumed, 1), "done");
  EXPECT_EQ(read_file(out / "anna_happy.pc2"), first);
  EXPECT_EQ(fs::last_write_time(out / "anna_happy.pc2"), made);
  for (const auto& entry : fs::directory_iterator(out)) {
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }
  const Json again = Json::parse(batch({study, "--json", "--resume"}).out);
  EXPECT_EQ(outcome(again, 1), "finished before");

  // Another input under the same name, or other options, are made again.
  fs::copy_file(test::sample_folder() / "ben_surprise.c3d", folder.path() / "ben_happy.c3d",
                fs::copy_options::overwrite_existing);
  const Json other = Json::parse(batch({study, "--json", "--resume", "--dry-run"}).out);
  EXPECT_EQ(outcome(other, 0), "finished before");
  EXPECT_EQ(outcome(other, 1), "not begun");
}

TEST(Batch, WrongUsageIsSaid) {
  const TemporaryFolder folder;
  const std::string study = study_in(folder).string();
  EXPECT_EQ(batch({study, "--jobs", "many"}).exit_code, 2);
  EXPECT_EQ(batch({(folder.path() / "none.toml").string()}).exit_code, 3);
  write_file(folder.path() / "wrong.toml",
             "[options.pictures]\npicture = false\n[[session]]\nsession = \"a.c3d\"\n");
  const test::ProgramRun wrong = batch({(folder.path() / "wrong.toml").string()});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("unknown option 'picture'"), std::string::npos) << wrong.err;
  EXPECT_NE(wrong.err.find("line 2"), std::string::npos) << wrong.err;
  EXPECT_EQ(batch({}).exit_code, 2);
  EXPECT_EQ(batch({"--dump-config"}).exit_code, 0);
  write_file(folder.path() / "name.csv", "session,output\na.c3d,a.ply\nb.c3d,k.xyz\n");
  const test::ProgramRun name = batch({(folder.path() / "name.csv").string(), "--dry-run"});
  EXPECT_EQ(name.exit_code, 2);
  EXPECT_NE(name.err.find("name.csv"), std::string::npos) << name.err;
  EXPECT_NE(name.err.find("line 3"), std::string::npos) << name.err;
}

}  // namespace
}  // namespace kinemesh::batch_test
