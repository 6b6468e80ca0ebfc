// Parallel loops on TBB whose results do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <functional>

#include "config/run_context.h"

namespace kinemesh {

/// Calls `body(begin, end)` for consecutive chunks of at most `grain` indices of [0, count) on
/// at most ctx.threads() threads. The chunk borders depend on count and grain alone, so that a
/// body which reduces per chunk stays deterministic. Exceptions thrown by a body reach the
/// caller; ctx is checked for cancellation before each chunk.
void parallel_chunks(const RunContext& ctx, std::size_t count, std::size_t grain,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Calls `body(i)` for every i in [0, count), `grain` at a time.
template <class Body>
void parallel_for(const RunContext& ctx, std::size_t count, std::size_t grain, Body&& body) {
  parallel_chunks(ctx, count, grain, [&body](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace kinemesh
