// Whether the tests run under the sanitizers, which make them several times slower.
#pragma once

namespace kinemesh::test {

/// There, one of several alike whole-program runs is enough: the release build runs all of them.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool under_sanitizers = true;
#else
inline constexpr bool under_sanitizers = false;
#endif

}  // namespace kinemesh::test
