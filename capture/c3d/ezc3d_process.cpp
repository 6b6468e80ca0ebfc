#include "capture/c3d/ezc3d_process.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <span>

#include "capture/c3d/ezc3d_reader.h"
#include "config/error.h"

namespace kinemesh {
namespace {

constexpr std::size_t reason_bytes = 1024;
constexpr int exit_done = 0;
constexpr int exit_refused = 1;
constexpr int exit_memory = 2;
constexpr std::size_t head_bytes = std::size_t{64} << 20;  // address space; used as needed

using Json = nlohmann::json;

Json json_of(const C3dParameter& p) {
  return {p.name,       p.description, p.locked,    static_cast<int>(p.type),
          p.dimensions, p.numbers,     p.characters};
}

std::vector<uint8_t> packed(const Ezc3dHead& head) {
  Json groups = Json::array();
  for (const C3dGroup& g : head.parameters.groups) {
    Json parameters = Json::array();
    for (const C3dParameter& p : g.parameters) parameters.push_back(json_of(p));
    groups.push_back({g.name, g.description, g.locked, std::move(parameters)});
  }
  Json events = Json::array();
  for (const C3dHeaderEvent& e : head.header_events) events.push_back({e.label, e.time_s});
  return Json::to_cbor(Json{std::move(groups), std::move(events), head.first_frame, head.rate_hz});
}

Ezc3dHead unpacked(std::span<const uint8_t> bytes) {
  const Json all = Json::from_cbor(bytes.begin(), bytes.end());
  Ezc3dHead head;
  for (const Json& g : all[0]) {
    C3dGroup group{.name = g[0], .description = g[1], .locked = g[2]};
    for (const Json& p : g[3]) {
      group.parameters.push_back({.name = p[0],
                                  .description = p[1],
                                  .locked = p[2],
                                  .type = static_cast<C3dType>(p[3].get<int>()),
                                  .dimensions = p[4].get<std::vector<uint8_t>>(),
                                  .numbers = p[5].get<std::vector<double>>(),
                                  .characters = p[6]});
    }
    head.parameters.groups.push_back(std::move(group));
  }
  for (const Json& e : all[1]) head.header_events.push_back({.label = e[0], .time_s = e[1]});
  head.first_frame = all[2];
  head.rate_hz = all[3];
  return head;
}

/// Memory that parent and child share: a reason, the arrays of a take one after the other, and the
/// head behind its length.
class SharedArrays {
 public:
  explicit SharedArrays(MarkerSequence& take) : take_(take) {
    const std::size_t samples = take.sample_count();
    size_ = reason_bytes + samples * (3 * sizeof(float) + sizeof(float) + 2) +
            (take.analog.values.size() + take.rotations.values.size()) * sizeof(float);
    size_ = (size_ + 7) / 8 * 8 + sizeof(uint64_t) + head_bytes;
    memory_ = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE,
                     MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory_ == MAP_FAILED) throw std::bad_alloc();
  }
  SharedArrays(const SharedArrays&) = delete;
  SharedArrays& operator=(const SharedArrays&) = delete;
  ~SharedArrays() { ::munmap(memory_, size_); }

  char* reason() { return static_cast<char*>(memory_); }
  void store(const Ezc3dHead& head) {
    const std::vector<uint8_t> bytes = packed(head);
    if (bytes.size() > head_bytes) throw std::bad_alloc();
    const uint64_t size = bytes.size();
    std::memcpy(head_at(), &size, sizeof size);
    std::memcpy(head_at() + sizeof size, bytes.data(), bytes.size());
    copy(true);
  }
  Ezc3dHead load() {
    copy(false);
    uint64_t size = 0;
    std::memcpy(&size, head_at(), sizeof size);
    const auto* bytes = reinterpret_cast<const uint8_t*>(head_at() + sizeof size);
    return unpacked({bytes, std::min<std::size_t>(size, head_bytes)});
  }

 private:
  char* head_at() { return static_cast<char*>(memory_) + size_ - head_bytes - sizeof(uint64_t); }
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
    one(take_.rotations.values.span());
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
    Ezc3dHead head;
    read_with_ezc3d(path, options, result, head);
    shared.store(head);
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

std::string read_with_ezc3d_apart(const std::filesystem::path& path, const C3dReadOptions& options,
                                  C3dReadResult& result, Ezc3dHead& head, const RunContext& ctx) {
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
  if (reason.empty()) head = shared.load();
  return reason;
}

void reread_with_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
                       C3dReadResult& result, const RunContext& ctx) {
  Ezc3dHead head;
  std::string why = ezc3d_refusal(result);
  if (!why.empty()) why = "ezc3d cannot read it: " + why;
  if (why.empty()) why = read_with_ezc3d_apart(path, options, result, head, ctx);
  if (!why.empty()) {
    throw InputError({.what = why, .file = path.string(), .remedy = "Leave out --reader ezc3d"});
  }
  std::ranges::fill(result.take.residuals(), 0.0F);
  std::ranges::fill(result.take.camera_masks(), uint8_t{0});
}

}  // namespace kinemesh
