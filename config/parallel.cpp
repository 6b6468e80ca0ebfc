#include "config/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace kinemesh {

void parallel_chunks(const RunContext& ctx, std::size_t count, std::size_t grain,
                     const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t step = std::max<std::size_t>(grain, 1);
  const std::size_t chunks = (count + step - 1) / step;
  const auto run_chunk = [&](std::size_t chunk) {
    ctx.check_cancelled();
    body(chunk * step, std::min(count, (chunk + 1) * step));
  };
  if (ctx.threads() <= 1 || chunks <= 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
    return;
  }
  tbb::task_arena arena(ctx.threads());
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run_chunk); });
}

}  // namespace kinemesh
