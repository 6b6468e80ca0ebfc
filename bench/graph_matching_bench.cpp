// The solver of graph matching beside the thesis' dual decomposition on the same problems, and the
// reader of .dd files beside a pass over the text. Counters: the gap that is left, in percent.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numeric>

#include "analysis/graph_matching/dd_file.h"
#include "analysis/graph_matching/solve_matching.h"
#include "tests/analysis/matching_instances.h"

using namespace kinemesh;

namespace {

void solve(benchmark::State& state, test::InstanceKind kind, const MatchingOptions& options) {
  const auto nodes = static_cast<uint32_t>(state.range(0));
  const MatchingProblem problem = test::make_instance(kind, nodes, 3);
  MatchingResult result;
  for (auto _ : state) result = solve_matching(problem, options);
  state.counters["gap_%"] =
      100.0 * (result.energy - result.bound) / std::max(1e-12, std::abs(result.energy));
  state.counters["iterations"] = static_cast<double>(result.iterations);
}

void ascent(benchmark::State& state) {
  solve(state, test::InstanceKind::geometric, {.time_limit_s = 60});
}
BENCHMARK(ascent)->Arg(6)->Arg(10)->Arg(16)->Unit(benchmark::kMillisecond);

void subgradient(benchmark::State& state) {
  solve(state, test::InstanceKind::geometric,
        {.method = MatchingMethod::subgradient, .time_limit_s = 60, .iterations = 300});
}
BENCHMARK(subgradient)->Arg(6)->Arg(10)->Arg(16)->Unit(benchmark::kMillisecond);

void ascent_sparse(benchmark::State& state) {
  solve(state, test::InstanceKind::sparse, {.time_limit_s = 60, .iterations = 40});
}
BENCHMARK(ascent_sparse)->Arg(14)->Arg(30)->Unit(benchmark::kMillisecond);

std::string text_of(benchmark::State& state) {
  const auto nodes = static_cast<uint32_t>(state.range(0));
  return format_dd(test::make_instance(test::InstanceKind::geometric, nodes, 3));
}

void read_dd_text(benchmark::State& state) {
  const std::string text = text_of(state);
  for (auto _ : state) benchmark::DoNotOptimize(parse_dd(text, "made"));
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(text.size()));
}
BENCHMARK(read_dd_text)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond);

void sum_of_text(benchmark::State& state) {
  const std::string text = text_of(state);
  for (auto _ : state) benchmark::DoNotOptimize(std::accumulate(text.begin(), text.end(), 0U));
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(text.size()));
}
BENCHMARK(sum_of_text)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond);

}  // namespace
