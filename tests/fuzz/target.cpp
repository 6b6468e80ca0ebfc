#include "tests/fuzz/target.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"

namespace kinemesh::fuzz {

Outcome run_target(const Target& target, std::span<const std::byte> bytes) {
  try {
    return target.run(bytes);
  } catch (const InternalError&) {
    throw;
  } catch (const Error&) {
    return Outcome::refused;
  }
}

Outcome run_on_file(std::span<const std::byte> bytes, const std::string& extension,
                    const std::function<Outcome(const std::filesystem::path&)>& reader) {
  const std::filesystem::path memory = "/dev/shm";
  static const std::filesystem::path folder =
      std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path();
  const std::filesystem::path path =
      folder / ("kinemesh_fuzz_" + std::to_string(::getpid()) + extension);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  struct Remove {
    const std::filesystem::path& path;
    ~Remove() {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  } remove{path};
  return reader(path);
}

std::vector<Seed> seeds_of(const Target& target, const std::filesystem::path& data) {
  std::vector<Seed> seeds = target.own_seeds ? target.own_seeds() : std::vector<Seed>{};
  std::vector<std::filesystem::path> paths;
  if (std::filesystem::is_directory(data)) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(data)) {
      const bool wanted =
          std::ranges::find(target.extensions, lower(entry.path().extension().string())) !=
          target.extensions.end();
      if (wanted && entry.is_regular_file() && entry.file_size() <= target.max_seed_bytes)
        paths.push_back(entry.path());
    }
  }
  std::ranges::sort(paths);
  for (const auto& path : paths)
    seeds.push_back({.name = path.filename().string(), .bytes = read_file(path)});
  std::erase_if(seeds, [&](const Seed& seed) {
    return run_target(target, std::as_bytes(std::span(seed.bytes))) == Outcome::refused;
  });
  if (target.payload) {
    for (Seed& seed : seeds) seed.payload = target.payload(seed.bytes);
  }
  return seeds;
}

}  // namespace kinemesh::fuzz
