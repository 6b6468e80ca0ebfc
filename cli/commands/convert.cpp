// kinemesh convert: a recorded session becomes an animated mesh, with pictures and a summary.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"
#include "config/version.h"
#include "mesh/formats/assumptions.h"
#include "mesh/formats/mesh_io.h"
#include "reconstruct/anonymous.h"
#include "reconstruct/convert_files.h"
#include "reconstruct/convert_summary.h"

namespace kinemesh::cli {
namespace {

struct State {
  ConvertJob job;
  ConvertFilesOptions options;
};

std::string written_text(const WrittenMesh& written) {
  std::vector<std::string> files = written.outputs;  // of the mesh's files the first and the last
  if (written.mesh_files.size() > 2) {
    files.insert(files.begin() + 1, "… " + std::to_string(written.mesh_files.size()) + " files …");
  }
  std::string text = "written     " + join(files, "\n            ");
  if (!written.lost.empty()) {
    text += "\nnot kept    " + join(written.lost, ", ", " and ") + ": " + written.format +
            " has no place for " + (written.lost.size() == 1 ? "that" : "these") +
            " ('kinemesh formats' lists which have)";
  }
  return text;
}

/// An animated mesh rather than a recorded session, judged by its name. C3D, TRC and CSV hold both;
/// they are sessions here.
bool is_mesh(const FormatRegistry& formats, const std::string& input) {
  std::error_code ignored;
  if (std::filesystem::is_directory(input, ignored)) return true;
  const Format* format = formats.reader_for(input);
  return format != nullptr && format->keeps.faces;
}

ExitCode convert_mesh(const FormatRegistry& formats, const State& state, Terminal& terminal) {
  const ConvertJob& job = state.job;
  if (job.output.empty()) {
    throw UsageError({.what = job.session + " is a mesh: its conversion needs a file to write",
                      .remedy = "Say which with -o, for example -o face.glb"});
  }
  state.options.validate();
  if (!job.previous.empty() || !job.edits.empty()) {
    throw UsageError({.what = job.session + " is a mesh: --topology and --edits are for sessions",
                      .remedy = "Give the session that was recorded"});
  }
  refuse_session_options(state.options, job.session);
  AnimationFile in = read_animation_file(formats, job.session, state.options.reading.c3d.unstated,
                                         terminal.run.part(0.0, 0.5, "reading"));
  for (const std::string& text :
       assumptions_of(in, job.session, state.options.reading.c3d.unstated)) {
    terminal.run.warn(text);
  }
  if (state.options.anonymous) anonymise_mesh(in.mesh);
  in.files.emplace_back(job.session);  // x.ply, when x.pc2 beside it is what was resolved
  OutputSet pending;
  const WriteResult out = add_animation(formats, in.mesh, job.output, state.options.writing,
                                        pending, terminal.run.part(0.5, 1.0, "writing"));
  refuse_to_replace(in.files, pending.paths());
  pending.commit();
  std::vector<std::string> files{out.files.begin(), out.files.end()};
  const std::vector<std::string> ends =
      files.size() > 2 ? std::vector{files.front(), files.back()} : files;
  const WrittenMesh written{.outputs = ends,
                            .mesh_files = std::move(files),
                            .format = out.format,
                            .lost = out.report.lost,
                            .max_error_mm = out.report.max_error_mm,
                            .rms_error_mm = out.report.rms_error_mm};
  if (terminal.json) {
    terminal.print(nlohmann::ordered_json{
        {"input", job.session},
        {"input_format", in.format},
        {"vertices", in.mesh.vertex_count()},
        {"frames", in.mesh.frame_count()},
        {"format", out.format},
        {"outputs", written.mesh_files},
        {"max_error_mm", written.max_error_mm},
        {"rms_error_mm", written.rms_error_mm},
        {"not_kept",
         written.lost}}.dump(2));
  } else if (!terminal.quiet) {
    terminal.print(job.session + ": " + count_of(in.mesh.vertex_count(), "vertex", "vertices") +
                   ", " + count_of(in.mesh.frame_count(), "frame"));
    for (const std::string& note : out.report.notes) terminal.print(note);
    terminal.print(written_text(written));
  }
  return ExitCode::done;
}

ExitCode convert(State& state, Terminal& terminal) {
  const FormatRegistry formats = all_formats();
  if (is_mesh(formats, state.job.session)) return convert_mesh(formats, state, terminal);
  if (state.job.output.empty()) {
    state.job.output = default_output(state.job.session, ".ply");
    if (state.options.anonymous) {
      terminal.run.warn("the files are named after the session, " + state.job.output +
                        ": give a name without a person's with -o");
    }
  }
  state.job.program = program_version();
  state.job.command = terminal.command_line;
  state.job.options_toml = terminal.options_toml;
  const ConvertFilesResult done = convert_files(formats, state.job, state.options, terminal.run);
  if (terminal.json) {
    terminal.print(summary_json(done.session, done.conversion, done.written));
  } else if (!terminal.quiet) {
    terminal.print(summary_text(done.session, done.conversion) + written_text(done.written));
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
              "kinemesh convert surprise.c3d -o surprise.ply --topology happy.ply\n"
              "kinemesh convert face.ply -o face.glb",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<State>();
            line.positional("SESSION", state->job.session,
                            "The session: C3D, TRC or CSV; or an animated mesh, to be "
                            "written in another format");
            line.option(
                "-o,--output", state->job.output, "OUT",
                "File of the animated mesh; its extension decides the format. By default the "
                "session's name with .ply ('#' and '%' become '-'), in the current folder");
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
