// The fuzz harness as a small framework: a table of readers, each with the files it grows from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace kinemesh::fuzz {

enum class Outcome { read, read_with_findings, refused };

/// One valid (or nearly valid) input from which mutants are made.
struct Seed {
  std::string name;
  std::string bytes;
  /// Where the payload begins: mutants that change only bytes from here on must not be refused.
  /// npos when the format gives no such promise.
  std::size_t payload = npos;
  static constexpr std::size_t npos = static_cast<std::size_t>(-1);
};

struct Target {
  std::string name;
  std::vector<std::string> extensions;  ///< of its seeds below the data folder, with the dot
  /// Runs the reader on the bytes. Typed errors (kinemesh::Error but InternalError) mean refused;
  /// anything else that escapes is a bug, as are crashes.
  std::function<Outcome(std::span<const std::byte>)> run;
  /// Generated seeds, so that fuzzing needs no data folder. May be empty.
  std::function<std::vector<Seed>()> own_seeds;
  /// Payload of a seed file; empty when there is none.
  std::function<std::size_t(const std::string& bytes)> payload;
  std::size_t max_seed_bytes = std::size_t{4} << 20;
};

/// All targets. To fuzz another reader, add a row in targets.cpp.
const std::vector<Target>& targets();

/// Runs a target and turns refusals into Outcome::refused.
Outcome run_target(const Target& target, std::span<const std::byte> bytes);

/// For readers that insist on a path: writes the bytes to a file with this extension in memory
/// (/dev/shm where there is one) and calls `reader` with it.
Outcome run_on_file(std::span<const std::byte> bytes, const std::string& extension,
                    const std::function<Outcome(const std::filesystem::path&)>& reader);

/// The target's generated seeds, then all files of its extensions below `data` that it reads.
std::vector<Seed> seeds_of(const Target& target, const std::filesystem::path& data);

}  // namespace kinemesh::fuzz
