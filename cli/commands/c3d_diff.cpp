// kinemesh c3d diff: what differs between two sessions.
#include "capture/session.h"
#include "capture/session_diff.h"
#include "cli/commands/commands.h"

namespace kinemesh::cli {

CommandSpec c3d_diff_command() {
  return {.path = "c3d diff",
          .summary = "Say what differs between two sessions: markers, values, events, parameters",
          .example = "kinemesh c3d diff before.c3d after.c3d --tolerance 0.1",
          .setup = [](CommandLine& line) -> Action {
            struct Arguments {
              std::string a, b;
              SessionReadOptions read;
              SessionDiffOptions diff;
              bool expect_identical = false;
            };
            auto args = std::make_shared<Arguments>();
            line.positional("A", args->a, "C3D, TRC, CSV or TSV file");
            line.positional("B", args->b, "The file to compare it with");
            line.parameters([args](ParameterSet& p) {
              args->read.declare(p);
              args->diff.declare(p);
            });
            line.flag("--expect-identical", args->expect_identical,
                      "Exit with status 3 if they differ; otherwise the status is 0 either way");
            line.json_output();
            return [args](Terminal& terminal) {
              const RunContext& run = terminal.run;
              const MarkerSequence a =
                  read_session(args->a, args->read, run.part(0, 0.4, "reading A"));
              const MarkerSequence b =
                  read_session(args->b, args->read, run.part(0.4, 0.8, "reading B"));
              const SessionDiffResult result =
                  diff_sessions(a, b, args->diff, run.part(0.8, 1.0, "comparing"));
              terminal.print(terminal.json ? diff_json(result, args->a, args->b)
                                           : diff_text(result, args->a, args->b));
              // Status 1, which diff(1) uses, means a bug in Kinemesh.
              return args->expect_identical && !result.identical() ? ExitCode::invalid_input
                                                                   : ExitCode::done;
            };
          }};
}

}  // namespace kinemesh::cli
