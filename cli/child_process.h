// Running this program again as a process of its own, so that whatever happens in it harms nobody
// else.
#pragma once

#include <sys/types.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace kinemesh::cli {

class ChildProcess {
 public:
  /// Starts this program with the arguments. It ends when this process does, is not reached by the
  /// terminal's Ctrl-C, and prints into files. Throws InternalError when it cannot be started.
  explicit ChildProcess(const std::vector<std::string>& arguments);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Ends it at once if it still runs.
  ~ChildProcess();

  /// True when it has ended; exit_code() and the texts are then known.
  bool ended();
  /// Asks it to stop (SIGINT).
  void interrupt() const;
  /// −1 when a signal ended it.
  int exit_code() const { return exit_code_; }
  int signal() const { return signal_; }
  std::string out() const { return content(out_.get()); }
  std::string err() const { return content(err_.get()); }

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  static std::string content(std::FILE* file);

  File out_, err_;
  pid_t pid_ = -1;
  int exit_code_ = -1;
  int signal_ = 0;
};

}  // namespace kinemesh::cli
