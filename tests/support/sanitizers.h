// Whether the tests run under the sanitizers, which make them several times slower.
#pragma once

#include <gtest/gtest.h>

namespace kinemesh::test {

/// There, one of several alike whole-program runs is enough: the release build runs all of them.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool under_sanitizers = true;
#else
inline constexpr bool under_sanitizers = false;
#endif

}  // namespace kinemesh::test

/// Leaves a test to the release build where another one takes the same path through the code: the
/// sanitizers would find nothing new in it, and its value is asserted there.
#define KINEMESH_LEAVE_TO_RELEASE(other) \
  if (kinemesh::test::under_sanitizers)  \
  GTEST_SKIP() << "in release only; " other " runs the same code here"
