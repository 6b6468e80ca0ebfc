// Entry point for libFuzzer and AFL++; see CMakeLists.txt for how to build it. The environment
// variable KINEMESH_FUZZ_TARGET names the target (default: the first).
#include <cstdlib>

#include "tests/fuzz/target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace kinemesh::fuzz;
  static const Target& target = []() -> const Target& {
    const char* wanted = std::getenv("KINEMESH_FUZZ_TARGET");
    for (const Target& t : targets()) {
      if (wanted != nullptr && t.name == wanted) return t;
    }
    return targets().front();
  }();
  run_target(target, {reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
