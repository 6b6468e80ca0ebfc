#include "capture/c3d/ezc3d_process.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <new>

#include "capture/c3d/ezc3d_reader.h"
#include "config/error.h"

namespace kinemesh {
namespace {

constexpr std::size_t reason_bytes = 1024;
constexpr int exit_done = 0;
constexpr int exit_refused = 1;
constexpr int exit_memory = 2;

/// Memory that parent and child share: a reason, then the arrays of a take one after the other.
class SharedArrays {
 public:
  explicit SharedArrays(MarkerSequence& take) : take_(take) {
    const std::size_t samples = take.sample_count();
    size_ = reason_bytes + samples * (3 * sizeof(float) + sizeof(float) + 2) +
            take.analog.values.size() * sizeof(float);
    memory_ = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory_ == MAP_FAILED) throw std::bad_alloc();
  }
  SharedArrays(const SharedArrays&) = delete;
  SharedArrays& operator=(const SharedArrays&) = delete;
  ~SharedArrays() { ::munmap(memory_, size_); }

  char* reason() { return static_cast<char*>(memory_); }
  void store() { copy(true); }
  void load() { copy(false); }

 private:
  void copy(bool store) {
    char* at = static_cast<char*>(memory_) + reason_bytes;
    const auto one = [&at, store](auto array) {
      if (array.empty()) return;
      if (store) {
        std::memcpy(at, array.data(), array.size_bytes());
      } else {
        std::memcpy(array.data(), at, array.size_bytes());
      }
      at += array.size_bytes();
    };
    one(take_.positions());
    one(take_.residuals());
    one(take_.analog.values.span());
    one(take_.flags());
    one(take_.camera_masks());
  }

  MarkerSequence& take_;
  void* memory_ = nullptr;
  std::size_t size_ = 0;
};

void limit(int what, rlim_t value) {
  const rlimit both{value, value};
  ::setrlimit(static_cast<__rlimit_resource_t>(what), &both);
}

/// ezc3d needs 11 to 18 bytes a byte of the file, and 0.02 to 0.05 s a megabyte.
void limit_child(std::size_t file_bytes) {
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, 10 + file_bytes / 2'000'000);
#if !defined(__SANITIZE_ADDRESS__)  // whose shadow memory alone is terabytes
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const std::size_t now = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  limit(RLIMIT_AS, now + (std::size_t{1} << 30) + 40 * file_bytes);
#endif
}

[[noreturn]] void run_child(const std::filesystem::path& path, const C3dReadOptions& options,
                            C3dReadResult& result, SharedArrays& shared) {
  int code = exit_done;
  try {
    limit_child(result.layout.file_bytes);
    reread_with_ezc3d(path, options, result, true);
    shared.store();
  } catch (const Error& e) {
    std::strncpy(shared.reason(), e.details().what.c_str(), reason_bytes - 1);
    code = exit_refused;
  } catch (const std::bad_alloc&) {
    code = exit_memory;
  } catch (...) {
    code = exit_refused;
  }
  ::_exit(code);  // nothing of the parent's is to be flushed or destroyed
}

std::string reason_of(int status, SharedArrays& shared) {
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    if (number == SIGXCPU || number == SIGKILL) return "ezc3d takes too long to read it";
    return "ezc3d crashes on it (signal " + std::to_string(number) + ")";
  }
  switch (WEXITSTATUS(status)) {
    case exit_done: return "";
    case exit_memory: return "ezc3d takes over 1 GiB and 40 times the file's size of memory for it";
    default: {
      const std::string reason = shared.reason();
      return reason.empty() ? "ezc3d cannot read it" : reason;
    }
  }
}

}  // namespace

std::string reread_with_ezc3d_apart(const std::filesystem::path& path,
                                    const C3dReadOptions& options, C3dReadResult& result,
                                    const RunContext& ctx) {
  SharedArrays shared(result.take);
  const pid_t child = ::fork();
  if (child < 0) return "no process could be started for ezc3d";
  if (child == 0) run_child(path, options, result, shared);
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (ctx.cancelled()) {
      ::kill(child, SIGKILL);
      ::waitpid(child, &status, 0);
      ctx.check_cancelled();
    }
    ::usleep(2000);
  }
  std::string reason = reason_of(status, shared);
  if (reason.empty()) shared.load();
  return reason;
}

}  // namespace kinemesh
