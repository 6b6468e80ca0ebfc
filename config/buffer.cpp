#include "config/buffer.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <new>
#include <string>

namespace kinemesh::detail {
namespace {

constexpr std::size_t least_in_a_file = std::size_t{64} << 20;

/// Buffers that memory has no room for lie in files without names in $TMPDIR (/var/tmp), which the
/// kernel pages: a sequence may be larger than memory. Here with their sizes.
struct MappedBuffers {
  std::atomic<std::size_t> count{0};
  std::mutex mutex;
  std::map<void*, std::size_t> sizes;
};
MappedBuffers& mapped_buffers() {
  static auto* const buffers = new MappedBuffers;  // buffers of static objects may outlive it
  return *buffers;
}

/// What the kernel could give without writing to swap; all there is when it does not say.
std::size_t available_bytes() {
  std::size_t kilobytes = ~std::size_t{0} >> 10U;
  std::FILE* const file = std::fopen("/proc/meminfo", "re");
  if (file == nullptr) return kilobytes << 10U;
  char line[128];
  while (std::fgets(line, sizeof line, file) != nullptr) {
    if (std::sscanf(line, "MemAvailable: %zu", &kilobytes) == 1) break;
  }
  std::fclose(file);
  return kilobytes << 10U;
}

/// A file without a name in the folder; negative where there can be none.
int nameless_file(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0) return file;
  std::string path = folder + "/kinemesh_XXXXXX";  // not every file system knows such files
  const int named = ::mkostemp(path.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(path.c_str());
  return named;
}

/// Memory whose pages the kernel may write to a file without a name; nullptr where that fails.
void* allocate_in_a_file(std::size_t bytes) {
  const char* const folder = std::getenv("TMPDIR");
  const std::string path = folder != nullptr && *folder != '\0' ? folder : "/var/tmp";
  const int file = nameless_file(path);
  if (file < 0) return nullptr;
  // The blocks are reserved: a full disk is an error here, not a signal at some later write.
  void* memory = MAP_FAILED;
  if (::posix_fallocate(file, 0, static_cast<off_t>(bytes)) == 0) {
    memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  }
  ::close(file);
  if (memory == MAP_FAILED) return nullptr;
  MappedBuffers& buffers = mapped_buffers();
  const std::lock_guard lock(buffers.mutex);
  buffers.sizes.emplace(memory, bytes);
  ++buffers.count;
  return memory;
}

}  // namespace

void* allocate_buffer(std::size_t bytes) {
  constexpr std::size_t cache_line = 64;
  constexpr std::size_t huge_page = std::size_t{2} << 20;
  if (bytes == 0) return nullptr;
  // Not for the largest: on virtual machines, huge pages that lie free have gone back to the host,
  // and to fetch hundreds of MB of them anew takes three times what ordinary pages take.
  constexpr std::size_t most = std::size_t{64} << 20;
  const bool huge = bytes >= 2 * huge_page && bytes <= most;
  const std::size_t alignment = huge ? huge_page : cache_line;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  if (rounded < bytes) throw std::bad_alloc();
  // What would take more than half of what is left lies in a file: memory is promised before it
  // is there, and who takes too much of it is ended without a word.
  if (bytes >= least_in_a_file && bytes > available_bytes() / 2) {
    if (void* const memory = allocate_in_a_file(rounded)) return memory;
  }
  void* memory = std::aligned_alloc(alignment, rounded);
  if (memory == nullptr && bytes >= least_in_a_file) memory = allocate_in_a_file(rounded);
  if (memory == nullptr) throw std::bad_alloc();
  // A hint only: where huge pages are off, ordinary ones serve.
  if (huge) ::madvise(memory, rounded, MADV_HUGEPAGE);
  return memory;
}

void release_buffer(void* memory) noexcept {
  MappedBuffers& buffers = mapped_buffers();
  if (memory != nullptr && buffers.count > 0) {
    const std::lock_guard lock(buffers.mutex);
    const auto found = buffers.sizes.find(memory);
    if (found != buffers.sizes.end()) {
      ::munmap(memory, found->second);
      buffers.sizes.erase(found);
      --buffers.count;
      return;
    }
  }
  std::free(memory);
}

}  // namespace kinemesh::detail
