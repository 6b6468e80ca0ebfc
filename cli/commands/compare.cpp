// kinemesh compare: where, when and by how much two performances differ.
#include <cmath>

#include "analysis/comparison/compare_files.h"
#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/text.h"
#include "config/version.h"

namespace kinemesh::cli {
namespace {

struct State {
  CompareJob job;
  CompareOptions options;
};

std::string in_words(const CompareFilesResult& done) {
  const ComparisonStory& story = done.story;
  const Comparison& c = story.comparison;
  const RegionResult& whole = story.regions.front();
  std::string text;
  for (const std::string& doubt : doubts_of(story)) text += doubt + "\n";
  text += "confidence         " + format_fixed(100.0 * c.mean_confidence, 0) + " %\n" +
          "shape difference   " + format_fixed(whole.shape_rms_mm, 3) + " mm (RMS, at rest)\n";
  if (c.warp) {
    text += "motion difference  " + format_fixed(whole.motion_rms_mm, 3) +
            " mm (RMS of displacements)\n" + "time               B does what A does " +
            format_fixed(1e3 * std::abs(c.warp->delay_s), 0) + " ms " +
            (c.warp->delay_s < 0 ? "earlier" : "later") + "\n";
  }
  std::vector<std::string> files;
  for (const auto& path : done.outputs) files.push_back(path.string());
  return text + "written            " + join(files, "\n                   ");
}

ExitCode compare(const State& state, Terminal& terminal) {
  CompareJob job = state.job;
  if (job.output.empty()) job.output = "comparison.html";
  job.program = program_version();
  job.command = terminal.command_line;
  job.options_toml = terminal.options_toml;
  const CompareFilesResult done = compare_files(all_formats(), job, state.options, terminal.run);
  if (terminal.json) {
    terminal.print(comparison_json(done.story));
  } else if (!terminal.quiet) {
    terminal.print(in_words(done));
  }
  return ExitCode::done;
}

}  // namespace

CommandSpec compare_command() {
  return {.path = "compare",
          .summary = "Say where, when and by how much two performances differ, in a report",
          .example =
              "kinemesh compare anna_happy.c3d ben_happy.c3d -o happy.html\n"
              "kinemesh compare before.ply after.ply --regions face.json --measures "
              "mouth.json -o report.html --anonymous",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<State>();
            CompareJob& job = state->job;
            line.positional("A", job.a, "A session (C3D, TRC, CSV) or an animated mesh");
            line.positional("B", job.b, "What is compared with it");
            line.option("-o,--output", job.output, "REPORT.html",
                        "The report; JSON and CSV lie beside it (default: comparison.html)");
            line.option("--map", job.map, "MAP", "Correspondence A → B, instead of matching");
            line.option("--landmarks", job.landmarks, "FILE",
                        "Pairs that the matching must meet, one a line: vertex of A, vertex of B");
            line.option("--regions", job.regions, "FILE",
                        "JSON: {\"mouth\": [\"LMOU*\", 17], …}, vertices or marker names of A");
            line.option("--measures", job.measures, "FILE",
                        "JSON: {\"mouth width\": {\"distance\": [\"LMOU01\", \"RMOU01\"]}, …}; "
                        "kinds: distance, excursion, opening");
            line.option("--truth", job.truth, "MAP",
                        "True correspondence A → B: adds curves of its errors");
            line.parameters([state](ParameterSet& p) { state->options.declare(p); });
            line.json_output();
            return [state](Terminal& terminal) { return compare(*state, terminal); };
          }};
}

}  // namespace kinemesh::cli
