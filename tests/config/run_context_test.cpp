#include "config/run_context.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

#include "config/error.h"
#include "config/parallel.h"

namespace kinemesh::run_context_test {
namespace {

TEST(RunContext, ProgressNeverGoesBackAndPartsMapIntoTheWhole) {
  std::vector<double> seen;
  std::vector<std::string> stages;
  RunContext ctx;
  ctx.set_progress([&](double f, std::string_view stage) {
    seen.push_back(f);
    stages.emplace_back(stage);
  });
  const RunContext second = ctx.part(0.5, 1.0, "second");
  const RunContext half = second.part(0.0, 0.5, "first half of second");
  ctx.part(0.0, 0.5, "first").progress(0.5);
  half.progress(1.0);
  ctx.progress(0.1);
  second.progress(7.0);
  EXPECT_EQ(seen, (std::vector<double>{0.25, 0.75, 1.0}));
  EXPECT_EQ(stages, (std::vector<std::string>{"first", "first half of second", "second"}));
}

TEST(RunContext, CancelReachesCopiesAndParts) {
  RunContext ctx;
  const RunContext part = ctx.part(0, 1, "x");
  EXPECT_NO_THROW(part.check_cancelled());
  std::thread([copy = ctx] { copy.cancel(); }).join();
  EXPECT_TRUE(part.cancelled());
  EXPECT_THROW(part.check_cancelled(), CancelledError);
}

TEST(RunContext, ZeroThreadsMeansAllOfThem) {
  RunContext ctx;
  EXPECT_GE(ctx.threads(), 1);
  EXPECT_EQ(ctx.set_threads(3).threads(), 3);
  EXPECT_THROW(ctx.set_threads(-1), UsageError);
}

TEST(Parallel, EveryIndexOnceAndChunksDoNotDependOnThreads) {
  for (const int threads : {1, 2, 4}) {
    RunContext ctx;
    ctx.set_threads(threads);
    std::vector<std::atomic<int>> hits(1003);
    std::vector<double> sums(11);
    parallel_chunks(ctx, hits.size(), 100, [&](std::size_t begin, std::size_t end) {
      EXPECT_EQ(begin % 100, 0U);
      for (std::size_t i = begin; i < end; ++i) {
        ++hits[i];
        sums[begin / 100] += 1.0 / static_cast<double>(i + 1);
      }
    });
    for (const auto& h : hits) EXPECT_EQ(h.load(), 1);
    EXPECT_NEAR(std::accumulate(sums.begin(), sums.end(), 0.0), 7.48842, 1e-3);
  }
}

TEST(Parallel, ExceptionsAndCancellationReachTheCaller) {
  RunContext ctx;
  ctx.set_threads(2);
  EXPECT_THROW(parallel_for(ctx, 100, 1,
                            [](std::size_t i) {
                              if (i == 57) throw InputError({.what = "bad"});
                            }),
               InputError);
  ctx.cancel();
  EXPECT_THROW(parallel_for(ctx, 100, 1, [](std::size_t) {}), CancelledError);
  EXPECT_NO_THROW(parallel_for(ctx, 0, 1, [](std::size_t) {}));
}

}  // namespace
}  // namespace kinemesh::run_context_test
