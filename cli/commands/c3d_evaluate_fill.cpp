// kinemesh c3d evaluate-fill: how well gaps of a session can be filled, by every method.
#include "capture/evaluate_fill.h"
#include "capture/marker_selection.h"
#include "capture/session.h"
#include "cli/commands/commands.h"

namespace kinemesh::cli {

CommandSpec c3d_evaluate_fill_command() {
  return {
      .path = "c3d evaluate-fill",
      .summary = "Remove known stretches, fill them by every method and say how far each is off",
      .example =
          "kinemesh c3d evaluate-fill smile.c3d\n"
          "kinemesh c3d evaluate-fill smile.c3d --markers 5 --gap 1 --trials 64 --seed 3 --json",
      .setup = [](CommandLine& line) -> Action {
        struct Arguments {
          std::string file;
          SessionReadOptions read;
          MarkerSelectionOptions selection;
          EvaluateFillOptions evaluation;
        };
        auto args = std::make_shared<Arguments>();
        line.positional("FILE", args->file, "C3D, TRC, CSV or TSV file");
        line.parameters([args](ParameterSet& p) {
          args->read.declare(p);
          args->selection.declare(p);
          args->evaluation.declare(p);
        });
        line.json_output();
        return [args](Terminal& terminal) {
          const RunContext& run = terminal.run;
          args->evaluation.validate();
          const MarkerSequence take =
              read_session(args->file, args->read, run.part(0.0, 0.02, "reading"));
          const auto selection = select_markers(take, args->selection, run);
          const EvaluateFillResult result = evaluate_fill(
              take.select(selection.chosen), args->evaluation, run.part(0.02, 1.0, "evaluating"));
          terminal.print(terminal.json ? evaluate_fill_json(result, args->evaluation, args->file)
                                       : evaluate_fill_text(result));
          return ExitCode::done;
        };
      }};
}

}  // namespace kinemesh::cli
