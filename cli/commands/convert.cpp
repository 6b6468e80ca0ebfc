// kinemesh convert: a recorded session becomes an animated mesh, with pictures and a summary.
#include <filesystem>

#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/text.h"
#include "config/version.h"
#include "reconstruct/convert_files.h"
#include "reconstruct/convert_summary.h"

namespace kinemesh::cli {
namespace {

struct State {
  ConvertJob job;
  ConvertFilesOptions options;
};

ExitCode convert(State& state, Terminal& terminal) {
  if (state.job.output.empty()) {
    state.job.output = std::filesystem::path(state.job.session).stem().string() + ".ply";
  }
  state.job.program = program_version();
  state.job.command = terminal.command_line;
  state.job.options_toml = terminal.options_toml;
  const ConvertFilesResult done =
      convert_files(all_formats(), state.job, state.options, terminal.run);
  if (terminal.json) {
    terminal.print(summary_json(done.session, done.conversion, done.outputs));
  } else if (!terminal.quiet) {
    terminal.print(summary_text(done.session, done.conversion) + "written     " +
                   join(done.outputs, "\n            "));
  }
  return ExitCode::done;
}

}  // namespace

CommandSpec convert_command() {
  return {.path = "convert",
          .summary = "Turn a recorded session into an animated mesh, with pictures and a report",
          .example =
              "kinemesh convert session.c3d -o face.ply\n"
              "kinemesh convert session.c3d -o face.pvd --stabilise --fill cubic --max-gap 0.1\n"
              "kinemesh convert surprise.c3d -o surprise.ply --topology happy.ply",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<State>();
            line.positional("SESSION", state->job.session, "The session: C3D, TRC or CSV");
            line.option(
                "-o,--output", state->job.output, "OUT",
                "File of the animated mesh; its extension decides the format. By default the "
                "session's name with .ply, in the current folder");
            line.option("--topology", state->job.previous, "PREVIOUS",
                        "Use the triangulation of this mesh again, by marker name");
            line.option("--edits", state->job.edits, "FILE",
                        "Edit the session by this list of steps first (see c3d process)");
            line.parameters([state](ParameterSet& p) { state->options.declare(p); });
            line.json_output();
            return [state](Terminal& terminal) { return convert(*state, terminal); };
          }};
}

}  // namespace kinemesh::cli
