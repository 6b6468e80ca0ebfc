// kinemesh solve-matching: a graph matching problem from a .dd file.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "analysis/graph_matching/dd_file.h"
#include "analysis/graph_matching/solve_matching.h"
#include "cli/commands/commands.h"
#include "config/text.h"

namespace kinemesh::cli {
namespace {

constexpr double shortest_search_s = 0.02;  // whatever reading took

struct Arguments {
  std::string problem;
  MatchingOptions options;
};

nlohmann::ordered_json as_json(const std::string& file, const MatchingResult& result) {
  nlohmann::ordered_json labelling = nlohmann::ordered_json::array();
  for (const uint32_t right : result.labelling) {
    right == unmatched ? labelling.push_back(nullptr) : labelling.push_back(right);
  }
  return {{"file", file},
          {"energy", result.energy},
          {"bound", result.bound},
          {"labelling", std::move(labelling)},
          {"iterations", result.iterations},
          {"branches", result.branches},
          {"seconds", result.seconds},
          {"certified", result.certified}};
}

const char* how_it_ended(const MatchingResult& result, const MatchingOptions& options) {
  if (result.certified) return "certified";
  if (result.time_is_up) return "not certified, the best within the time given";
  if (result.iterations >= options.iterations) return "not certified within --matching-iterations";
  if (options.gap >= certified_gap) return "not certified, but within --gap";
  return "not certified: the bound could not be raised further";
}

std::string in_words(const MatchingResult& result, const MatchingOptions& options) {
  std::string text = "energy " + format_number(result.energy) + ", bound " +
                     format_number(result.bound) + ": " + how_it_ended(result, options) + "; " +
                     format_fixed(1e3 * result.seconds, 1) + " ms\n";
  std::vector<std::string> matches;
  for (std::size_t i = 0; i < result.labelling.size(); ++i) {
    const uint32_t right = result.labelling[i];
    matches.push_back(std::to_string(i) + "→" +
                      (right == unmatched ? std::string("–") : std::to_string(right)));
  }
  return text + join(matches, " ", " ");
}

/// Says how much memory reading takes, when that is much: the text, and about twice that for what
/// it says.
void say_memory_of_reading(const std::string& path, const RunContext& ctx) {
  std::error_code ignored;
  const std::uintmax_t bytes = std::filesystem::file_size(path, ignored);
  if (ignored || 3 * bytes < 200'000'000) return;
  ctx.info("reading " + path + ": about " + format_fixed(3e-6 * static_cast<double>(bytes), 0) +
           " MB");
}

ExitCode run_solve(const Arguments& args, Terminal& terminal) {
  const auto begin = std::chrono::steady_clock::now();
  say_memory_of_reading(args.problem, terminal.run);
  const MatchingProblem problem = read_dd(args.problem);
  // The limit is the whole command's: what reading took is gone.
  const std::chrono::duration<double> reading = std::chrono::steady_clock::now() - begin;
  MatchingOptions options = args.options;
  options.time_limit_s = std::max(std::min(shortest_search_s, args.options.time_limit_s),
                                  options.time_limit_s - reading.count());
  const MatchingResult result = solve_matching(problem, options, terminal.run);
  terminal.print(terminal.json ? as_json(args.problem, result).dump(2) : in_words(result, options));
  return ExitCode::done;
}

}  // namespace

CommandSpec solve_matching_command() {
  return {.path = "solve-matching",
          .summary = "Solve a graph matching problem from a .dd file, with a certificate",
          .example =
              "kinemesh solve-matching pair.dd --json\n"
              "kinemesh solve-matching pair.dd --time-limit 60 --matching-method subgradient",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("FILE", args->problem, "Problem in the .dd format");
            line.parameters([args](ParameterSet& p) { args->options.declare(p); });
            line.json_output();
            return [args](Terminal& terminal) { return run_solve(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
