// What the program shows on stderr: log lines and progress.
#pragma once

#include <memory>
#include <string>

#include "config/run_context.h"

namespace kinemesh::cli {

enum class Verbosity { quiet, normal, verbose };

/// Log sink and progress display of one run. Bar on a terminal, plain lines otherwise.
class Console {
 public:
  explicit Console(Verbosity verbosity);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// Connects the context's log and progress to this console, which must outlive it.
  void attach(RunContext& context);
  /// Prints "kinemesh: error: …" whatever the verbosity.
  void error(const std::string& message);
  /// Removes the progress bar, if one is shown.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kinemesh::cli
