#include "tests/fuzz/memory_account.h"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>

namespace {

std::atomic<std::size_t> in_use{0};
std::atomic<std::size_t> base{0};
std::atomic<std::size_t> peak{0};
std::atomic<std::size_t> ceiling{SIZE_MAX};
std::atomic<bool> exceeded{false};

}  // namespace

#if !defined(__SANITIZE_ADDRESS__)
// glibc's own entry points, under the names it keeps for such replacements.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace {

bool allowed(std::size_t bytes) {
  const std::size_t limit = ceiling.load(std::memory_order_relaxed);
  const std::size_t used = in_use.load(std::memory_order_relaxed);
  if (limit == SIZE_MAX || (bytes <= limit && used <= limit - bytes)) return true;
  exceeded.store(true, std::memory_order_relaxed);
  errno = ENOMEM;
  return false;
}

void* counted(void* memory) {
  if (memory == nullptr) return nullptr;
  const std::size_t now = in_use += ::malloc_usable_size(memory);
  if (now > peak.load(std::memory_order_relaxed)) peak.store(now, std::memory_order_relaxed);
  return memory;
}

}  // namespace

extern "C" {
void* malloc(std::size_t bytes) { return allowed(bytes) ? counted(__libc_malloc(bytes)) : nullptr; }
void* calloc(std::size_t count, std::size_t size) {
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes) || !allowed(bytes)) return nullptr;
  return counted(__libc_calloc(count, size));
}
void* realloc(void* memory, std::size_t bytes) {
  if (!allowed(bytes)) return nullptr;
  const std::size_t before = memory == nullptr ? 0 : ::malloc_usable_size(memory);
  void* moved = __libc_realloc(memory, bytes);
  if (moved != nullptr || bytes == 0) in_use -= before;
  return counted(moved);
}
void* memalign(std::size_t alignment, std::size_t bytes) {
  return allowed(bytes) ? counted(__libc_memalign(alignment, bytes)) : nullptr;
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) { return memalign(alignment, bytes); }
int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) {
  *memory = memalign(alignment, bytes);
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) {
  if (memory == nullptr) return;
  in_use -= ::malloc_usable_size(memory);
  __libc_free(memory);
}
}
#endif

namespace kinemesh::fuzz {

void begin_account(std::size_t limit) {
  const std::size_t now = in_use.load();
  base = now;
  peak = now;
  exceeded = false;
  ceiling = limit >= SIZE_MAX - now ? SIZE_MAX - 1 : now + limit;
}

Account end_account() {
  ceiling = SIZE_MAX;
  return {.peak = peak.load() - base.load(), .exceeded = exceeded.load()};
}

}  // namespace kinemesh::fuzz
