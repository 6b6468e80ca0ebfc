// The solver of graph matching on larger problems with a planted matching, in the manner of the
// public benchmarks. One JSON object per line.
//
//   graph_matching_figures [LIMIT_S] [KIND] [NODES] [name=value …]   names as of solve-matching
//   graph_matching_figures write FOLDER      the problems as .dd files instead
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>

#include "analysis/graph_matching/dd_file.h"
#include "analysis/graph_matching/solve_matching.h"
#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/matching_problems.h"

namespace {

using namespace kinemesh;
using test::ProblemKind;

struct Case {
  const char* name;
  ProblemKind kind;
  std::vector<uint32_t> nodes;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"complete", ProblemKind::complete, {19, 20}}, {"car", ProblemKind::car, {19, 30, 48}},
      {"house", ProblemKind::house, {19, 30}},       {"flow", ProblemKind::flow, {48, 60}},
      {"worms", ProblemKind::worms, {60}},           {"synth", ProblemKind::synth, {30, 60}}};
  return all;
}

void solve(const Case& it, uint32_t nodes, const MatchingOptions& options) {
  const test::PlantedProblem made = plant_problem(it.kind, 7 + nodes, {.nodes = nodes});
  const std::clock_t begin = std::clock();
  const MatchingResult r = solve_matching(made.problem, options);
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf(
      "{\"case\": \"%s\", \"nodes\": %u, \"assignments\": %zu, \"pairs\": %zu, \"planted\": %.4f, "
      "\"energy\": %.4f, \"bound\": %.4f, \"gap\": %.4f, \"certified\": %s, \"seconds\": %.3f, "
      "\"cpu_s\": %.3f, \"iterations\": %lld}\n",
      it.name, nodes, made.problem.assignments.size(), made.problem.pairs.size(),
      made.problem.energy(made.planted), r.energy, r.bound,
      (r.energy - r.bound) / std::max(1e-12, std::abs(r.energy)), r.certified ? "true" : "false",
      r.seconds, cpu, static_cast<long long>(r.iterations));
  std::fflush(stdout);
}

void write(const std::filesystem::path& folder) {
  for (const Case& it : cases()) {
    for (const uint32_t nodes : it.nodes) {
      OutputFile file(folder / (it.name + std::to_string(nodes) + ".dd"));
      file.write(format_dd(plant_problem(it.kind, 7 + nodes, {.nodes = nodes}).problem));
      file.commit();
    }
  }
}

int run(const std::vector<std::string>& words) {
  if (words.size() == 2 && words[0] == "write") {
    write(words[1]);
    return 0;
  }
  MatchingOptions options{.time_limit_s = 1.0};
  ParameterSet parameters;
  options.declare(parameters);
  std::string kind;
  uint32_t only = 0;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals != std::string::npos) {
      if (Parameter* p = parameters.find(word.substr(0, equals))) p->set({word.substr(equals + 1)});
    } else if (word.find_first_not_of("0123456789.") != std::string::npos) {
      kind = word;
    } else if (kind.empty()) {
      options.time_limit_s = std::atof(word.c_str());
    } else {
      only = static_cast<uint32_t>(std::atoi(word.c_str()));
    }
  }
  for (const Case& it : cases()) {
    if (!kind.empty() && kind != it.name) continue;
    for (const uint32_t nodes : it.nodes) {
      if (only == 0 || only == nodes) solve(it, nodes, options);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
