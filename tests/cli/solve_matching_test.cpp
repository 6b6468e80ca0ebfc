// kinemesh solve-matching as a user runs it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/command_test.h"

namespace kinemesh::solve_matching_test {
namespace {

class SolveMatchingCommand : public test::CommandTest {
 protected:
  SolveMatchingCommand() : CommandTest(KINEMESH_PROGRAM " solve-matching") {}
  std::string write(const std::string& name, const std::string& text) {
    const std::string path = place(name);
    std::ofstream(path) << text;
    return path;
  }
};

const char* const small = "p 3 2 4 1\na 0 0 0 -1\na 1 0 1 -2\na 2 1 1 -1.5\na 3 2 0 4\ne 0 2 -1\n";

TEST_F(SolveMatchingCommand, PrintsTheResultAsJson) {
  for (const std::string method : {"ascent", "subgradient"}) {
    ASSERT_EQ(run(write("a.dd", small) + " --json --time-limit 2 --matching-method " + method), 0);
    const nlohmann::json json = nlohmann::json::parse(output_);
    EXPECT_NEAR(json["energy"].get<double>(), -3.5, 1e-12);
    EXPECT_NEAR(json["bound"].get<double>(), -3.5, 1e-3);
    EXPECT_EQ(json["labelling"], nlohmann::json::parse("[0,1,null]"));
    EXPECT_TRUE(json["certified"].get<bool>());
    EXPECT_GE(json["iterations"].get<int>(), 0);
    EXPECT_GE(json["seconds"].get<double>(), 0.0);
  }
}

TEST_F(SolveMatchingCommand, PrintsTheMatchesInWords) {
  ASSERT_EQ(run(write("a.dd", small)), 0);
  EXPECT_NE(output_.find("certified"), std::string::npos);
  EXPECT_NE(output_.find("0→0"), std::string::npos);
}

TEST_F(SolveMatchingCommand, MistakesHaveTheirExitCode) {
  EXPECT_EQ(run(write("bad.dd", "p 1 1 1 0\na 0 0 0 NaN\n")), 3);
  EXPECT_NE(errors_.find("line 2"), std::string::npos) << errors_;
  EXPECT_EQ(run("missing.dd"), 3);
  EXPECT_EQ(run(write("a.dd", small) + " --time-limit -1"), 2);
  EXPECT_EQ(run(""), 2);
}

}  // namespace
}  // namespace kinemesh::solve_matching_test
