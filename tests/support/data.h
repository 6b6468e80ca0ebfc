// Where tests find real data and the project's samples.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace kinemesh::test {

/// The folder named by KINEMESH_DATA, or ../shared/data beside the checkout.
std::filesystem::path data_folder();
/// sample_c3d of this checkout.
std::filesystem::path sample_folder();

}  // namespace kinemesh::test

/// Skips the running test, saying why, when `relative` is not below the data folder. With
/// KINEMESH_REQUIRE_DATA set, as in CI, a missing file fails the test instead.
#define KINEMESH_NEED_DATA(relative)                                                           \
  do {                                                                                         \
    const auto needed = ::kinemesh::test::data_folder() / (relative);                          \
    if (!std::filesystem::exists(needed)) {                                                    \
      if (std::getenv("KINEMESH_REQUIRE_DATA") != nullptr) FAIL() << needed << " is missing";  \
      GTEST_SKIP() << needed << " is missing; set KINEMESH_DATA to the folder with test data"; \
    }                                                                                          \
  } while (false)
