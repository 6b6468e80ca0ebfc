// kinemesh c3d export: sessions out to tables and arrays.
#include "capture/formats/session_export.h"
#include "capture/session.h"
#include "cli/commands/commands.h"
#include "config/output_file.h"
#include "config/text.h"

namespace kinemesh::cli {

CommandSpec c3d_export_command() {
  return {.path = "c3d export",
          .summary = "Write a session as CSV, TRC, JSON or NumPy arrays",
          .example =
              "kinemesh c3d export smile.c3d -o smile.csv\n"
              "kinemesh c3d export smile.c3d -o smile.npz",
          .setup = [](CommandLine& line) -> Action {
            struct Arguments {
              std::string file, output;
              SessionReadOptions read;
            };
            auto args = std::make_shared<Arguments>();
            line.positional("FILE", args->file, "C3D, TRC, CSV or TSV file");
            line.option("-o,--output", args->output, "OUT",
                        "File to write; .csv, .trc, .json or .npz chooses the format", true);
            line.parameters([args](ParameterSet& p) { args->read.declare(p); });
            return [args](Terminal& terminal) {
              export_format_of(args->output);  // a wrong extension is said before the file is read
              refuse_to_replace({args->file}, {args->output});
              const MarkerSequence take =
                  read_session(args->file, args->read, terminal.run.part(0, 0.5, "reading"));
              const SessionExportResult result =
                  export_session(take, args->output, terminal.run.part(0.5, 1.0, "writing"));
              for (const auto& file : result.files) {
                if (!terminal.quiet) terminal.print("Wrote " + file.string());
              }
              if (!result.left_out.empty()) {
                terminal.print("This format cannot hold: " + join(result.left_out, ", ", " and "));
              }
              return ExitCode::done;
            };
          }};
}

}  // namespace kinemesh::cli
