// kinemesh animate: markers drive a scan of the same face.
#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/text.h"
#include "config/version.h"
#include "reconstruct/animate_files.h"

namespace kinemesh::cli {
namespace {

struct State {
  AnimateJob job;
  AnimateFilesOptions options;
};

ExitCode animate(State& state, Terminal& terminal) {
  state.job.program = program_version();
  state.job.command = terminal.command_line;
  state.job.options_toml = terminal.options_toml;
  const AnimateFilesResult done =
      animate_files(all_formats(), state.job, state.options, terminal.run);
  if (terminal.json) {
    terminal.print(done.json);
    return ExitCode::done;
  }
  if (terminal.quiet) return ExitCode::done;
  const AnimateResult& r = done.result;
  terminal.print("scan        " + count_of(r.scan.positions.size(), "vertex", "vertices") +
                 ", neutral frame " + std::to_string(r.neutral_frame));
  terminal.print("attached    " + count_of(r.registration.markers.size(), "marker") + " of " +
                 std::to_string(r.labels.size()) + ", root mean square distance " +
                 format_fixed(r.registration.rms_mm, 2) + " mm");
  terminal.print("driven      " + count_of(r.drive.animation.frame_count(), "frame") + ", noise " +
                 format_fixed(r.drive.noise_mm, 2) + " mm, reach " +
                 format_fixed(r.drive.reach_mm, 0) + " mm");
  terminal.print("written     " + join(done.outputs, "\n            "));
  return ExitCode::done;
}

}  // namespace

CommandSpec animate_command() {
  return {.path = "animate",
          .summary = "Move a face scan by the markers of a session",
          .example =
              "kinemesh animate anna.ply anna_happy.c3d -o anna_happy.glb\n"
              "kinemesh animate anna.obj happy.c3d -o happy.ply --points anna_points.csv",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<State>();
            line.positional("SCAN", state->job.scan, "The subject's face as a mesh, at rest");
            line.positional("SESSION", state->job.session, "The recorded session");
            line.option("-o,--output", state->job.output, "OUT",
                        "File of the animated scan; its extension decides the format", true);
            line.option("--points", state->job.places, "FILE",
                        "CSV that says where the markers sit: label,face,b0,b1,b2 or label,vertex "
                        "or label,x,y,z; found when not given");
            line.parameters([state](ParameterSet& p) { state->options.declare(p); });
            line.json_output();
            return [state](Terminal& terminal) { return animate(*state, terminal); };
          }};
}

}  // namespace kinemesh::cli
