#include "tests/support/data.h"

#include <cstdlib>

namespace kinemesh::test {

std::filesystem::path data_folder() {
  const char* given = std::getenv("KINEMESH_DATA");
  return given != nullptr && *given != '\0' ? given : KINEMESH_DEFAULT_DATA;
}

std::filesystem::path sample_folder() { return KINEMESH_SAMPLES; }

}  // namespace kinemesh::test
