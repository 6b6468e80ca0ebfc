#include "config/buffer.h"

#include <sys/mman.h>

#include <cstdlib>
#include <new>

namespace kinemesh::detail {

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
  void* memory = std::aligned_alloc(alignment, rounded);
  if (memory == nullptr) throw std::bad_alloc();
  // A hint only: where huge pages are off, ordinary ones serve.
  if (huge) ::madvise(memory, rounded, MADV_HUGEPAGE);
  return memory;
}

void release_buffer(void* memory) noexcept { std::free(memory); }

}  // namespace kinemesh::detail
