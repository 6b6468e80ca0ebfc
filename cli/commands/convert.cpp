// kinemesh convert: a recorded session becomes an animated mesh, with pictures and a summary.
#include "reconstruct/convert.h"

#include <filesystem>

#include "capture/edit_list.h"
#include "capture/session.h"
#include "cli/commands/commands.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "config/text.h"
#include "config/version.h"
#include "mesh/formats/mesh_io.h"
#include "reconstruct/convert_summary.h"
#include "report/contact_sheet.h"
#include "report/gap_chart.h"
#include "report/image.h"

namespace kinemesh::cli {
namespace {

namespace fs = std::filesystem;

struct State {
  std::string session;
  std::string output;
  std::string previous;
  std::string edits;
  bool pictures = true;
  SessionReadOptions reading;
  ConvertOptions options;
  WriteOptions writing;
  ContactSheetOptions sheet;

  void declare(ParameterSet& p) {
    reading.declare(p);
    options.declare(p);
    p.group("output", "Output");
    writing.declare(p);
    p.group("pictures", "Pictures");
    p.flag("pictures", pictures, "draw the mesh at a few frames, and the gaps over time");
    sheet.declare(p);
  }
};

/// `face` for out/face.ply, out/face_####.obj and the folder out/face/.
fs::path stem_of(const fs::path& output) {
  const fs::path file = output.has_filename() ? output : output.parent_path();
  std::string name = file.stem().string();
  while (!name.empty() && (name.back() == '#' || name.back() == '_')) name.pop_back();
  return (output.has_filename() ? file.parent_path() : file) / (name.empty() ? "mesh" : name);
}

fs::path beside(const fs::path& stem, const std::string& suffix) {
  return stem.parent_path() / (stem.filename().string() + suffix);
}

Provenance provenance_of(const State& state, const Terminal& terminal) {
  Provenance p;
  p.program = program_version();
  p.command = terminal.command_line;
  p.options = terminal.options_toml;
  p.inputs.push_back({state.session, sha256_of_file(state.session)});
  if (!state.previous.empty() && fs::is_regular_file(state.previous)) {
    p.inputs.push_back({state.previous, sha256_of_file(state.previous)});
  }
  if (!state.edits.empty()) p.inputs.push_back({state.edits, sha256_of_file(state.edits)});
  return p;
}

void draw_pictures(const State& state, const ConvertResult& result, const fs::path& stem,
                   OutputSet& files, const RunContext& ctx) {
  ContactSheetOptions sheet = state.sheet;
  sheet.title = fs::path(state.session).filename().string();
  sheet.subtitle = count_of(result.markers.size(), "marker") + ", " +
                   count_of(result.animation.frame_count(), "frame") + " at " +
                   format_number(result.animation.rate_hz) + " Hz";
  const Canvas frames = draw_contact_sheet(result.animation, sheet, ctx).sheet;
  files.add(beside(stem, "_frames.png"), encode_png(frames.raster(png_scale(frames))));
  ctx.check_cancelled();
  GapChart chart = gap_chart_of(result);
  chart.subtitle = sheet.title;
  const Canvas gaps = draw_gap_chart(chart);
  files.add(beside(stem, "_gaps.png"), encode_png(gaps.raster(png_scale(gaps))));
  ctx.check_cancelled();
}

/// All outputs of one conversion; they appear together, or none of them.
std::vector<std::string> write_outputs(const State& state, const MarkerSequence& session,
                                       const FormatRegistry& formats, const ConvertResult& result,
                                       const Terminal& terminal) {
  OutputSet files;
  const WriteResult written = add_animation(formats, result.animation, state.output, state.writing,
                                            files, terminal.run.part(0.7, 0.85, "writing"));
  for (const std::string& note : written.report.notes) terminal.run.info(note);
  // A numbered sequence is named by its first and last file.
  std::vector<std::string> outputs{written.files.front().string()};
  if (written.files.size() > 1) outputs.push_back(written.files.back().string());
  const fs::path stem = stem_of(state.output);
  if (state.pictures) {
    draw_pictures(state, result, stem, files, terminal.run.part(0.85, 1.0, "drawing"));
  }
  files.add(beside(stem, "_quality.csv"), quality_csv(result));
  for (std::size_t i = written.files.size(); i < files.paths().size(); ++i) {
    outputs.push_back(files.paths()[i].string());
  }
  const fs::path summary = beside(stem, "_summary.json");
  outputs.push_back(summary.string());
  files.add(summary, summary_json(session, result, outputs));
  files.commit();
  return outputs;
}

ExitCode convert(State& state, Terminal& terminal) {
  const FormatRegistry formats = builtin_mesh_formats();
  MarkerSequence session =
      read_session(state.session, state.reading, terminal.run.part(0.0, 0.05, "reading"));
  if (!state.edits.empty()) {
    EditResult edited =
        apply_edits(session, read_edits(state.edits), terminal.run.part(0.05, 0.1, "editing"));
    session = std::move(edited.take);
    for (const std::string& done : edited.done) terminal.run.info(done);
  }
  // A wrong name or format is said before the work is done, not after it.
  output_format(formats, state.output, state.writing, session.frame_count());
  std::optional<Mesh> previous;
  if (!state.previous.empty()) previous = read_mesh(formats, state.previous, {}, terminal.run);
  ConvertResult result =
      convert_session(session, state.options, previous, terminal.run.part(0.1, 0.7, "converting"));
  result.animation.provenance = provenance_of(state, terminal);
  const std::vector<std::string> outputs = write_outputs(state, session, formats, result, terminal);
  terminal.run.progress(1.0);
  if (terminal.json) {
    terminal.print(summary_json(session, result, outputs));
  } else {
    terminal.print(summary_text(session, result) + "written     " +
                   join(outputs, "\n            "));
  }
  return ExitCode::done;
}

}  // namespace

CommandSpec convert_command() {
  return {.path = "convert",
          .summary = "Turn a recorded session into an animated mesh, with pictures and a summary",
          .example =
              "kinemesh convert session.c3d -o face.ply\n"
              "kinemesh convert session.c3d -o face.pvd --stabilise --max-gap 0.1\n"
              "kinemesh convert surprise.c3d -o surprise.ply --topology happy.ply",
          .setup = [](CommandLine& line) -> Action {
            auto state = std::make_shared<State>();
            line.positional("SESSION", state->session, "The session: C3D, TRC or CSV");
            line.option("-o,--output", state->output, "OUT",
                        "File of the animated mesh; its extension decides the format", true);
            line.option("--topology", state->previous, "PREVIOUS",
                        "Use the triangulation of this mesh again, by marker name");
            line.option("--edits", state->edits, "FILE",
                        "Edit the session by this list of steps first (see c3d process)");
            line.parameters([state](ParameterSet& p) { state->declare(p); });
            line.json_output();
            return [state](Terminal& terminal) { return convert(*state, terminal); };
          }};
}

}  // namespace kinemesh::cli
