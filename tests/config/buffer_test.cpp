#include "config/buffer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdint>

#include "tests/support/sanitizers.h"

namespace kinemesh::buffer_test {
namespace {

/// No more memory than there is, until it is destroyed.
class NoMoreMemory {
 public:
  NoMoreMemory() {
    ::getrlimit(RLIMIT_DATA, &before_);
    rlimit none = before_;
    none.rlim_cur = std::size_t{16} << 20;
    ::setrlimit(RLIMIT_DATA, &none);
  }
  ~NoMoreMemory() { ::setrlimit(RLIMIT_DATA, &before_); }
  NoMoreMemory(const NoMoreMemory&) = delete;
  NoMoreMemory& operator=(const NoMoreMemory&) = delete;

 private:
  rlimit before_{};
};

TEST(Buffer, WhatMemoryHasNoRoomForLiesInAFile) {
  if (test::under_sanitizers)
    GTEST_SKIP() << "the sanitizer ends a program that runs out of memory";
  constexpr std::size_t count = std::size_t{20} << 20;
  Buffer<uint32_t> large;
  {
    const NoMoreMemory limit;
    EXPECT_EQ(std::aligned_alloc(64, count * sizeof(uint32_t)), nullptr);
    large = Buffer<uint32_t>(count);
    for (std::size_t i = 0; i < count; i += 512) large[i] = static_cast<uint32_t>(7 * i);
  }
  const Buffer<uint32_t> moved = std::move(large);
  for (std::size_t i = 0; i < count; i += 512) ASSERT_EQ(moved[i], static_cast<uint32_t>(7 * i));
}

TEST(Buffer, WithoutAFolderForTheFileMemoryIsOut) {
  if (test::under_sanitizers)
    GTEST_SKIP() << "the sanitizer ends a program that runs out of memory";
  ASSERT_EQ(::setenv("TMPDIR", "/nonexistent", 1), 0);
  const NoMoreMemory limit;
  EXPECT_THROW(Buffer<char>(std::size_t{128} << 20), std::bad_alloc);
  ::unsetenv("TMPDIR");
}

}  // namespace
}  // namespace kinemesh::buffer_test
