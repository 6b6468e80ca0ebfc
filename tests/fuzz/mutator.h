// Mutants of a seed, determined by a number: the same number gives the same bytes everywhere.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/target.h"

namespace kinemesh::fuzz {

/// A small generator whose sequence is the same on every platform (splitmix64).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t next();
  /// In [0, bound); 0 when bound is 0.
  std::size_t below(std::size_t bound);

 private:
  uint64_t state_;
};

struct Mutant {
  std::size_t seed = 0;       ///< index
  bool payload_only = false;  ///< size and everything before the payload are the seed's
  std::string bytes;
};

/// Mutant `number` of the seeds. One in four changes only the payload, where the seed has one.
Mutant make_mutant(std::span<const Seed> seeds, uint64_t number);

}  // namespace kinemesh::fuzz
