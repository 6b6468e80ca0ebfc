#include "analysis/graph_matching/solve_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/graph_matching/search_state.h"
#include "config/text.h"

namespace kinemesh {

void MatchingOptions::declare(ParameterSet& p) {
  p.group("matching", "Graph matching");
  p.choice("matching-method", method,
           {{MatchingMethod::ascent, "ascent", "dual ascent with branch and bound"},
            {MatchingMethod::subgradient, "subgradient",
             "dual decomposition by projected subgradients, as in the thesis"}},
           "How the lower bound is found");
  p.number("time-limit", time_limit_s,
           {.unit = "s", .min = 0.001, .max = 1e6, .help = "Stop searching after this long"});
  p.number("gap", gap,
           {.min = 0.0,
            .max = 1.0,
            .help = "Stop when the bound is this close to the energy, relative to it"});
  p.number("matching-iterations", iterations,
           {.min = 1, .max = 1e9, .help = "Passes over the dual, or subgradient steps, at most"});
  p.number("local-size", local_size,
           {.min = 2,
            .max = 5,
            .help = "Left nodes in each local subproblem of the subgradient method"});
  p.number("bound-memory", memory_mb,
           {.unit = "MB", .min = 1, .max = 1e6, .help = "Memory that the lower bound may use"});
}

namespace graph_matching {
namespace {

constexpr double tiny_gap = 1e-12;      // energies (rescaled) that differ by less are the same
constexpr double worth_saying = 200e6;  // bytes

}  // namespace

SearchState::SearchState(const MatchingProblem& problem, const MatchingOptions& options,
                         const RunContext& ctx, Clock::time_point begin)
    : options_(options),
      ctx_(ctx),
      begin_(begin),
      table_(problem),
      local_(table_, ctx.seed()),
      least_(least_costs(table_)),
      simple_bound_(graph_matching::simple_bound(table_, least_)),
      sum_of_magnitudes_(table_.sum_of_magnitudes()) {
  local_.start_greedy();  // whatever the time limit, there is a matching
}

double SearchState::cutoff() const {
  return energy() - std::max(options_.gap * std::abs(energy()), tiny_gap);
}

double SearchState::rounding() const {
  const double steps = static_cast<double>(table_.left_count()) + static_cast<double>(iterations_);
  return std::numeric_limits<double>::epsilon() * steps * sum_of_magnitudes_;
}

double SearchState::seconds() const {
  return std::chrono::duration<double>(Clock::now() - begin_).count();
}

bool SearchState::time_is_up() {
  if (!out_of_time_) out_of_time_ = seconds() >= options_.time_limit_s;
  return out_of_time_;
}

bool SearchState::stop() {
  ctx_.check_cancelled();
  return time_is_up() || iterations_ >= options_.iterations;
}

void SearchState::offer(const std::vector<uint32_t>& assignments) {
  Matching matching(table_.left_count(), unmatched);
  for (const uint32_t a : assignments) matching[table_.left(a)] = a;
  local_.start_from(matching);
  local_.search(5 + table_.left_count() / 4, [this] { return stop(); });
}

void SearchState::improve(uint64_t work) {
  if (table_.size() == 0) return;
  const uint64_t until = local_.work() + work;
  while (local_.work() < until && energy() > simple_bound_ + tiny_gap && !stop()) {
    if (starts_ % 4 == 0) {
      local_.start_greedy();
    } else if (starts_ % 2 == 1) {
      local_.start_grown(least_);
    } else {
      local_.start_near_best(2 + static_cast<uint32_t>(starts_ % 7) * table_.left_count() / 14);
    }
    ++starts_;
    local_.search(20 + 2 * table_.left_count(), [this] { return stop(); });
  }
}

}  // namespace graph_matching

namespace {

/// Left and right nodes that an assignment names.
std::size_t nodes_in_use(const MatchingProblem& problem) {
  std::vector<char> left(problem.left_count, 0), right(problem.right_count, 0);
  for (const MatchingAssignment& a : problem.assignments) left[a.left] = right[a.right] = 1;
  return static_cast<std::size_t>(std::ranges::count(left, 1) + std::ranges::count(right, 1));
}

/// Says before the work how much memory it may take, when that is much.
void say_memory(const MatchingProblem& problem, const MatchingOptions& options,
                const RunContext& ctx) {
  using graph_matching::PairTable;
  const double size = static_cast<double>(problem.assignments.size());
  const double elements = size + static_cast<double>(nodes_in_use(problem));
  const bool dense = problem.assignments.size() <= PairTable::dense_assignments;
  const double table = 2.0 * sizeof(PairTable::Entry) * static_cast<double>(problem.pairs.size()) +
                       (dense ? sizeof(double) * size * size : 0.0);
  const double bound = std::min(16.0 * elements * elements, 1e6 * options.memory_mb);
  if (table + bound < graph_matching::worth_saying) return;
  ctx.info("matching " + std::to_string(problem.assignments.size()) + " assignments and " +
           std::to_string(problem.pairs.size()) + " pairs: about " + format_fixed(1e-6 * table, 0) +
           " MB for their costs and at most " + format_fixed(1e-6 * bound, 0) +
           " MB for the bound (--bound-memory)");
}

}  // namespace

MatchingResult solve_matching(const MatchingProblem& problem, const MatchingOptions& options,
                              const RunContext& ctx) {
  const auto begin = graph_matching::Clock::now();
  options.validate();
  problem.validate();
  say_memory(problem, options, ctx);
  graph_matching::SearchState state(problem, options, ctx, begin);
  MatchingResult result;
  const double bound = options.method == MatchingMethod::subgradient
                           ? graph_matching::bound_by_subgradient(state)
                           : graph_matching::bound_by_ascent(state, result.branches);
  const std::vector<uint32_t> nothing(problem.left_count, unmatched);
  result.labelling = nothing;
  const graph_matching::Matching& best = state.local().best();
  for (uint32_t i = 0; i < problem.left_count; ++i) {
    if (best[i] != unmatched) result.labelling[i] = problem.assignments[best[i]].right;
  }
  result.energy = problem.energy(result.labelling);
  if (result.energy > problem.constant) {
    result.labelling = nothing;
    result.energy = problem.constant;
  }
  const double proven = std::max(bound - state.rounding(), state.simple_bound());
  result.bound =
      std::min(std::ldexp(proven, -state.table().exponent()) + problem.constant, result.energy);
  result.iterations = state.iterations();
  result.seconds = state.seconds();
  result.time_is_up = state.was_out_of_time();
  // Relative to what the matching gains; a constant, which no choice changes, does not count.
  const double gain = result.energy - problem.constant;
  const double same = 2.0 * (graph_matching::tiny_gap + state.rounding());
  result.certified =
      result.energy - result.bound <=
      std::max(certified_gap * std::abs(gain), std::ldexp(same, -state.table().exponent()));
  return result;
}

}  // namespace kinemesh
