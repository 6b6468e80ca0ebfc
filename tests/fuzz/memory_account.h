// Counts the memory that is in use, and refuses more than a limit.
#pragma once

#include <cstddef>

namespace kinemesh::fuzz {

/// From here on the bytes allocated beyond what is in use now may not exceed `limit`: further
/// allocations fail. Replaces malloc and its kin; without effect under the address sanitizer.
void begin_account(std::size_t limit);
/// Ends the limit. Returns the peak since begin_account(), and whether an allocation was refused.
struct Account {
  std::size_t peak = 0;
  bool exceeded = false;
};
Account end_account();

}  // namespace kinemesh::fuzz
