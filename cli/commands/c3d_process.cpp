// kinemesh c3d process: a session is cleaned, or edited by a list, without touching the original.
#include <filesystem>

#include "capture/c3d/point_table.h"
#include "capture/c3d/writer.h"
#include "capture/clean.h"
#include "capture/clean_picture.h"
#include "capture/edit_list.h"
#include "capture/formats/session_export.h"
#include "capture/idle_options.h"
#include "capture/session.h"
#include "cli/commands/commands.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "config/text.h"
#include "report/gap_chart.h"  // png_scale
#include "report/image.h"

namespace kinemesh::cli {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string file, output, edits, record;
  bool picture = false;
  SessionReadOptions read;
  CleanOptions clean;
  C3dWriteOptions write;

  void declare(ParameterSet& p) {
    read.declare(p);
    clean.declare(p);
    p.group("output", "Output");
    write.declare(p);
    p.flag("picture", picture, "draw what was missing and what was done about it");
  }
};

bool is_c3d(const fs::path& path) { return lower(path.extension().string()) == ".c3d"; }

/// A list of edits is all that is done: beside it, an option of cleaning would be ignored.
void refuse_beside_edits(const Arguments& args) {
  if (args.edits.empty()) return;
  std::vector<std::string> idle = changed_options(args.clean);
  if (!args.record.empty()) idle.emplace_back("--record");
  if (idle.empty()) return;
  throw UsageError({.what = "--edits applies its steps and nothing else: " + join(idle, ", ") +
                            " would do nothing",
                    .remedy = "Write such a step into " + args.edits +
                              " (do = \"fill\", \"filter\", "
                              "\"stabilise\", …), or leave out one of the two"});
}

constexpr std::string_view seal = "# written by kinemesh, sum ";

/// The list with a line that tells whether somebody changed it afterwards.
std::string sealed(const std::string& list) {
  return std::string(seal) + sha256_of(list).substr(0, 16) + "\n" + list;
}

/// A record that a person has edited, or wrote, is work that must not be lost.
void refuse_to_replace_edited(const std::string& record) {
  std::error_code ignored;
  if (!fs::is_regular_file(record, ignored)) return;
  const std::string text = read_file(record);
  const std::size_t line = text.find('\n');
  if (line != std::string::npos && text == sealed(text.substr(line + 1))) return;
  throw UsageError({.what = "The list of edits there was changed by hand and would be replaced",
                    .file = record,
                    .remedy = "Apply it with --edits " + record +
                              ", or have the new list written elsewhere with --record FILE"});
}

/// Writes the take in the format of the extension; says what it cannot hold.
void write_take(const Arguments& args, const MarkerSequence& take, Terminal& terminal) {
  const RunContext ctx = terminal.run.part(0.9, 1.0, "writing");
  if (is_c3d(args.output)) {
    write_c3d(take, args.output, args.write, ctx);  // warns of what is lost
    return;
  }
  if (millimetres_in(take.origin.unit).value_or(1.0) != 1.0) {
    terminal.run.warn("Only C3D is written in " + take.origin.unit + "; this file is in mm.");
  }
  for (const std::string& part : export_session(take, args.output, ctx).left_out) {
    terminal.run.warn("This format cannot hold " + part + ".");
  }
}

ExitCode process(Arguments& args, Terminal& terminal) {
  if (!is_c3d(args.output))
    export_format_of(args.output, ".c3d, ");  // said before the work is done
  refuse_beside_edits(args);
  EditList steps;
  if (!args.edits.empty()) steps = read_edits(args.edits);
  if (args.record.empty() && args.edits.empty()) args.record = args.output + ".edits.toml";
  const std::string picture = args.picture ? args.output + ".png" : "";
  std::vector<fs::path> inputs = files_read(steps);
  inputs.insert(inputs.end(), {args.file, args.edits, args.clean.template_file});
  refuse_to_replace(inputs, {args.output, args.edits.empty() ? args.record : "", picture});
  if (!args.clean.template_file.empty()) {
    if (!fs::exists(args.clean.template_file)) {
      throw InputError({.what = "The template does not exist",
                        .file = args.clean.template_file,
                        .remedy = "Name a labelled take of the same subject"});
    }
    args.clean.template_file = fs::absolute(args.clean.template_file).string();
  }
  if (args.edits.empty()) refuse_to_replace_edited(args.record);
  const MarkerSequence take =
      read_session(args.file, args.read, terminal.run.part(0.0, 0.1, "reading"));
  const RunContext working = terminal.run.part(0.1, 0.9, "processing");
  CleanResult result;
  if (args.edits.empty()) {
    result = clean_take(take, args.clean, working);
  } else {
    result.edits = std::move(steps);
    EditResult edited = apply_edits(take, result.edits, working);
    result.take = std::move(edited.take);
    result.done = std::move(edited.done);
  }
  write_take(args, result.take, terminal);
  std::vector<std::string> outputs{args.output};
  if (args.edits.empty()) {
    outputs.push_back(args.record);
    write_file(outputs.back(), sealed(edits_toml(result.edits)));
  }
  if (args.picture) {
    outputs.push_back(picture);
    const Canvas canvas = draw_cleaning(take, result.take, result.edits,
                                        fs::path(args.file).filename().string(), terminal.run);
    write_file(outputs.back(), encode_png(canvas.raster(png_scale(canvas))));
  }
  std::string text;
  for (const std::string& done : result.done) text += "- " + done + "\n";
  for (const StageTime& t : result.times) {
    terminal.run.info(t.stage + " took " + format_fixed(t.seconds, 3) + " s");
  }
  if (!terminal.quiet) terminal.print(text + "written  " + join(outputs, "\n         "));
  return ExitCode::done;
}

}  // namespace

CommandSpec c3d_process_command() {
  return {
      .path = "c3d process",
      .summary = "Clean a session, or edit it by a list of steps, without touching the original",
      .example =
          "kinemesh c3d process smile.c3d -o clean.c3d\n"
          "kinemesh c3d process smile.c3d -o clean.trc --filter butterworth --stabilise\n"
          "kinemesh c3d process smile.c3d -o clean.c3d --edits smile.edits.toml",
      .setup = [](CommandLine& line) -> Action {
        auto args = std::make_shared<Arguments>();
        line.positional("IN", args->file, "C3D, TRC, CSV or TSV file");
        line.option("-o,--output", args->output, "OUT",
                    "File to write; .c3d, .trc, .csv, .json or .npz chooses the format", true);
        line.option("--edits", args->edits, "FILE",
                    "Apply this list of editing steps, and nothing else");
        line.option("--record", args->record, "FILE",
                    "Where the list of what was done is written; by default OUT.edits.toml");
        line.parameters([args](ParameterSet& p) { args->declare(p); });
        return [args](Terminal& terminal) { return process(*args, terminal); };
      }};
}

}  // namespace kinemesh::cli
