// kinemesh c3d check: lint, second opinion and repair.
#include "capture/c3d/check.h"
#include "capture/c3d/repair.h"
#include "cli/commands/commands.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::vector<std::string> files;
  bool repair = false;
  std::string output;
  C3dCheckOptions check;
};

ExitCode run_check(const Arguments& args, Terminal& terminal) {
  std::vector<C3dCheckResult> results;
  bool errors = false;
  for (std::size_t i = 0; i < args.files.size(); ++i) {
    const auto share = [&](std::size_t k) {
      return static_cast<double>(k) / static_cast<double>(args.files.size());
    };
    results.push_back(check_session(args.files[i], args.check,
                                    terminal.run.part(share(i), share(i + 1), args.files[i])));
    errors = errors || results.back().has_errors();
    if (!terminal.json) terminal.print(check_text(results.back()));
  }
  if (terminal.json) terminal.print(check_json(results));
  return errors ? ExitCode::invalid_input : ExitCode::done;
}

ExitCode run_repair(const Arguments& args, Terminal& terminal) {
  if (args.files.size() != 1) {
    throw UsageError({.what = "--repair takes one file at a time",
                      .remedy = "Repair the files one after the other"});
  }
  const C3dRepairResult result = repair_c3d(args.files[0], args.output, args.check, terminal.run);
  terminal.print(terminal.json ? repair_json(result) : repair_text(result));
  return result.healthy() ? ExitCode::done : ExitCode::invalid_input;
}

}  // namespace

CommandSpec c3d_check_command() {
  return {.path = "c3d check",
          .summary = "Say what is wrong in C3D files and what to do about it, and repair them",
          .example =
              "kinemesh c3d check *.c3d\n"
              "kinemesh c3d check broken.c3d --repair -o repaired.c3d",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positionals("FILE", args->files, "C3D files; TRC, CSV and TSV sessions too");
            line.flag("--repair", args->repair,
                      "Write a repaired copy of the one FILE to the file that -o names; the "
                      "original is never changed");
            line.option("-o,--output", args->output, "OUT",
                        "Where --repair writes the repaired file");
            line.parameters([args](ParameterSet& p) { args->check.declare(p); });
            line.json_output();
            return [args](Terminal& terminal) {
              if (args->repair == args->output.empty()) {
                throw UsageError({.what = "--repair and -o OUT belong together"});
              }
              return args->repair ? run_repair(*args, terminal) : run_check(*args, terminal);
            };
          }};
}

}  // namespace kinemesh::cli
