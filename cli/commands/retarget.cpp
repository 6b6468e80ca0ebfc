// kinemesh retarget: the motion of one subject's mesh on another's.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/output_file.h"
#include "config/text.h"
#include "config/version.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/surface_map_io.h"
#include "reconstruct/output_names.h"
#include "reconstruct/retarget.h"

namespace kinemesh::cli {
namespace {

struct State {
  std::string animation, source_rest, target_rest, map, output;
  ReadOptions reading;
  WriteOptions writing;
};

ExitCode run(State& state, Terminal& terminal) {
  const FormatRegistry formats = all_formats();
  const std::vector<std::filesystem::path> inputs{state.animation, state.source_rest,
                                                  state.target_rest, state.map};
  refuse_to_replace(inputs, {state.output});
  const RunContext reading = terminal.run.part(0.0, 0.2, "reading");
  const AnimatedMesh source = read_animation(formats, state.animation, state.reading, reading);
  const Mesh rest = read_mesh(formats, state.source_rest, state.reading, reading);
  const Mesh target = read_mesh(formats, state.target_rest, state.reading, reading);
  const SurfaceMap map = read_surface_map(state.map);
  output_format(formats, state.output, state.writing, source.frame_count());
  RetargetResult result =
      retarget(source, rest, target, map, terminal.run.part(0.2, 0.8, "transferring"));
  result.animation.provenance =
      provenance_of(program_version(), terminal.command_line, terminal.options_toml, inputs);
  const WriteResult written =
      write_animation(formats, result.animation, state.output, state.writing,
                      terminal.run.part(0.8, 1.0, "writing"));
  if (terminal.json) {
    terminal.print(nlohmann::ordered_json{
        {"vertices", target.positions.size()},
        {"frames", source.frame_count()},
        {"scale", result.scale},
        {"faces_without_source", result.faces_without_source},
        {"factor_s", result.factor_seconds},
        {"frames_s", result.frames_seconds},
        {"outputs", std::vector<std::string>(written.files.begin(), written.files.end())}}
                       .dump(2));
  } else if (!terminal.quiet) {
    if (result.faces_without_source > 0) {
      terminal.print(count_of(result.faces_without_source, "face") +
                     " of the target have no counterpart and follow their surroundings");
    }
    terminal.print("retargeted  " + count_of(source.frame_count(), "frame") + " to " +
                   count_of(target.positions.size(), "vertex", "vertices"));
    terminal.print("written     " + written.files.front().string());
  }
  return ExitCode::done;
}

}  // namespace

CommandSpec retarget_command() {
  return {.path = "retarget",
          .summary = "Move an animation onto another subject's mesh",
          .example =
              "kinemesh retarget anna_happy.ply anna.ply ben.ply --map anna_to_ben.csv -o "
              "ben_happy.ply",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<State>();
            line.positional("SRC_ANIM", state->animation, "The animation to transfer");
            line.positional("SRC_REST", state->source_rest, "Its mesh at rest");
            line.positional("TGT_REST", state->target_rest, "The other subject's mesh at rest");
            line.option("--map", state->map, "MAP",
                        "Surface map from source to target (.csv, .json or .npz)", true);
            line.option("-o,--output", state->output, "OUT",
                        "File of the animation; its extension decides the format", true);
            line.parameters([state](ParameterSet& p) {
              state->reading.declare(p);
              state->writing.declare(p);
            });
            line.json_output();
            return [state](Terminal& terminal) { return run(*state, terminal); };
          }};
}

}  // namespace kinemesh::cli
