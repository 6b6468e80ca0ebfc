// Runs the kinemesh program as a user would, and collects what it prints.
#pragma once

#include <string>
#include <vector>

namespace kinemesh::test {

struct ProgramRun {
  int exit_code = -1;  ///< −1 when a signal ended it
  std::string out;
  std::string err;
};

/// Runs `program` with the arguments; after `interrupt_after_s` (if ≥ 0) it is sent SIGINT.
ProgramRun run_program(const std::string& program, const std::vector<std::string>& arguments,
                       double interrupt_after_s = -1.0);

}  // namespace kinemesh::test
