// A fixture for one command of the program, run in a folder of its own as a shell runs it.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "config/input_file.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::test {

class CommandTest : public ::testing::Test {
 protected:
  /// `command` with the program before it: "…/kinemesh match".
  explicit CommandTest(std::string command) : command_(std::move(command)) {}

  std::string place(const std::string& name) const { return (folder_.path() / name).string(); }
  /// Exit code; what was printed is in output_ and errors_.
  int run(const std::string& arguments) {
    const std::string line =
        command_ + " " + arguments + " > " + place("stdout") + " 2> " + place("stderr");
    const int status = std::system(line.c_str());
    output_ = read_file(place("stdout"));
    errors_ = read_file(place("stderr"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  TemporaryFolder folder_;
  std::string output_, errors_;

 private:
  std::string command_;
};

}  // namespace kinemesh::test
