// kinemesh c3d info: what is in a session.
#include "capture/c3d/summary.h"
#include "capture/session.h"
#include "cli/commands/commands.h"

namespace kinemesh::cli {

CommandSpec c3d_info_command() {
  return {.path = "c3d info",
          .summary = "Show what a session holds: subjects, markers, rate, duration, gaps, events",
          .example = "kinemesh c3d info smile.c3d\nkinemesh c3d info smile.c3d --json",
          .setup = [](CommandLine& line) -> Action {
            struct Arguments {
              std::string file;
              SessionReadOptions read;
            };
            auto args = std::make_shared<Arguments>();
            line.positional("FILE", args->file, "C3D, TRC, CSV or TSV file");
            line.parameters([args](ParameterSet& p) { args->read.declare(p); });
            line.json_output();
            return [args](Terminal& terminal) {
              const SessionSummaryResult result =
                  summarise_session(args->file, args->read, terminal.run);
              terminal.print(terminal.json ? summary_json(result.summary)
                                           : summary_text(result.summary));
              return ExitCode::done;
            };
          }};
}

}  // namespace kinemesh::cli
