// Writes the seeds of one fuzz target to a folder, for libFuzzer to begin with. Large files are
// left out: what is wrong with readers shows in small ones, and libFuzzer runs those faster.
//   fuzz_seeds TARGET FOLDER [MAX_BYTES]
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/fuzz/target.h"
#include "tests/support/data.h"

int main(int argc, char** argv) {
  using namespace kinemesh::fuzz;
  if (argc < 3) {
    std::cerr << "usage: fuzz_seeds TARGET FOLDER [MAX_BYTES]; the targets are";
    for (const Target& t : targets()) std::cerr << ' ' << t.name;
    std::cerr << '\n';
    return 2;
  }
  const std::filesystem::path folder = argv[2];
  const std::size_t most = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 100'000;
  for (const Target& target : targets()) {
    if (target.name != argv[1]) continue;
    std::filesystem::create_directories(folder);
    std::size_t number = 0;
    for (const Seed& seed : seeds_of(target, kinemesh::test::data_folder())) {
      if (seed.bytes.size() > most) continue;
      std::ofstream(folder / (std::to_string(number++) + "-" + seed.name), std::ios::binary)
          << seed.bytes;
    }
    std::cout << number << " seeds in " << folder.string() << '\n';
    return 0;
  }
  std::cerr << "fuzz_seeds: there is no target " << argv[1] << '\n';
  return 2;
}
