// kinemesh deformation: strain and change of curvature of an animated mesh.
#include "analysis/deformation.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/deformation_output.h"
#include "analysis/jumps.h"
#include "cli/commands/commands.h"
#include "config/text.h"
#include "mesh/formats/mesh_io.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::string animation, output, rest;
  bool directions = false;
  DeformationOptions deformation;
  ReadOptions read;
};

ExitCode run_deformation(Arguments& args, Terminal& terminal) {
  const FormatRegistry formats = builtin_mesh_formats();
  const AnimatedMesh animation =
      read_animation(formats, args.animation, args.read, terminal.run.part(0.0, 0.2, "reading"));
  warn_of_jumps(animation, terminal.run);
  std::optional<Mesh> rest;
  if (!args.rest.empty()) rest = read_mesh(formats, args.rest, args.read, terminal.run);
  args.deformation.directions = args.directions;
  const DeformationResult result =
      deformation_of(animation, args.deformation, terminal.run.part(0.2, 0.8, "deformation"),
                     rest ? &*rest : nullptr);
  OutputSet files;
  add_deformation_files(files, args.output, animation, result, terminal.run);
  const std::size_t written = files.paths().size();
  files.commit();
  const nlohmann::ordered_json json{{"animation", args.animation},
                                    {"output", args.output},
                                    {"vertices", result.values.vertex_count},
                                    {"frames", result.values.frame_count},
                                    {"largest", result.largest},
                                    {"degenerate_faces", result.degenerate_faces},
                                    {"isolated_vertices", result.isolated_vertices},
                                    {"files", written}};
  std::string text = "deformation of " +
                     count_of(result.values.vertex_count, "vertex", "vertices") + " in " +
                     count_of(result.values.frame_count, "frame") + ", at most " +
                     format_number(double{result.largest}) + "\nwritten     " + args.output;
  if (written > 1) text += " (" + count_of(written, "file") + ")";
  if (result.degenerate_faces > 0) {
    text += "\n" + count_of(result.degenerate_faces, "triangle") + " without area left out";
  }
  terminal.print(terminal.json ? json.dump(2) : text);
  return ExitCode::done;
}

}  // namespace

CommandSpec deformation_command() {
  return {.path = "deformation",
          .summary = "Measure how much the surface is deformed, at each vertex in each frame",
          .example =
              "kinemesh deformation face.ply -o deformation.npz\n"
              "kinemesh deformation horse.ply --strain lambda --curvature-weight 7 -o out.pvd",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional("ANIM", args->animation, "Animated mesh");
            line.option("-o,--output", args->output, "OUT",
                        "OUT.npz, .csv (curves), .pvd (VTP per frame) or .ply (coloured meshes)",
                        true);
            line.option("--rest-mesh", args->rest, "MESH",
                        "Rest pose from another take of the same subject");
            line.flag("--directions", args->directions,
                      "Also write the direction of the largest stretch (.npz)");
            line.parameters([args](ParameterSet& p) {
              args->deformation.declare(p);
              args->read.declare(p);
            });
            line.json_output();
            return [args](Terminal& terminal) { return run_deformation(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
