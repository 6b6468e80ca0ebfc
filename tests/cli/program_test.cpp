// The program as a whole: help, exit codes, options from file and command line.
#include <gtest/gtest.h>

#include "config/output_file.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::program_test {
namespace {

using test::ProgramRun;
using test::TemporaryFolder;

ProgramRun run(const std::vector<std::string>& arguments) {
  return test::run_program(KINEMESH_PROGRAM, arguments);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Program, HelpNamesCommandsAndExitCodes) {
  const ProgramRun help = run({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_TRUE(contains(help.out, "convert"));
  EXPECT_TRUE(contains(help.out, "130 cancelled"));
  const ProgramRun sub = run({"convert", "--help"});
  EXPECT_EQ(sub.exit_code, 0);
  EXPECT_TRUE(contains(sub.out, "Example:"));
  EXPECT_TRUE(contains(sub.out, "--max-gap"));
  EXPECT_TRUE(contains(sub.out, "--no-report"));
  EXPECT_FALSE(contains(sub.out, "{false}"));
}

TEST(Program, VersionNamesTheProgram) {
  const ProgramRun version = run({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out.rfind("kinemesh ", 0), 0U);
}

TEST(Program, WrongUsageIsExitCodeTwo) {
  EXPECT_EQ(run({}).exit_code, 2);
  EXPECT_EQ(run({"nonsense"}).exit_code, 2);
  EXPECT_EQ(run({"convert"}).exit_code, 2);
  EXPECT_EQ(run({"hash", "x", "--threads", "-3"}).exit_code, 2);
}

TEST(Program, UnreadableInputIsExitCodeThree) {
  const ProgramRun missing = run({"hash", "/no/such/file"});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_TRUE(contains(missing.err, "/no/such/file: cannot read"));
  EXPECT_TRUE(missing.out.empty());
  EXPECT_EQ(run({"hash", "/"}).exit_code, 3);
  EXPECT_EQ(run({"hash", "/dev/null"}).exit_code, 3);
}

TEST(Program, AWrongValueNamesTheOptionAndWhatIsAllowed) {
  const ProgramRun wrong = run({"convert", "x.c3d", "-o", "y.ply", "--max-gap", "-1"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_TRUE(contains(wrong.err, "--max-gap: it was given as '-1', but must be a number from"))
      << wrong.err;
}

TEST(Program, TheCommandLineWinsOverTheFile) {
  const TemporaryFolder folder;
  const std::string config = (folder.path() / "lab.toml").string();
  write_file(config, "[gaps]\nmax-gap = 0.25\nfill = \"cubic\"\n");
  const ProgramRun dump = run({"convert", "x.c3d", "-o", "y.ply", "--config", config, "--max-gap",
                               "0.125", "--dump-config"});
  EXPECT_EQ(dump.exit_code, 0) << dump.err;
  EXPECT_TRUE(contains(dump.out, "max-gap = 0.125\n"));
  EXPECT_TRUE(contains(dump.out, "fill = \"cubic\"\n"));
  // What was dumped loads, and dumps the same again.
  write_file(config, dump.out);
  EXPECT_EQ(run({"convert", "x.c3d", "-o", "y.ply", "--config", config, "--dump-config"}).out,
            dump.out);
  write_file(config, "[gaps]\nmax-gop = 0.25\n");
  const ProgramRun unknown = run({"convert", "x.c3d", "-o", "y.ply", "--config", config});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_TRUE(contains(unknown.err, "Did you mean 'max-gap' in table [gaps]?")) << unknown.err;
}

}  // namespace
}  // namespace kinemesh::program_test
