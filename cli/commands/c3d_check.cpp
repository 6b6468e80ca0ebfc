// kinemesh c3d check: lint and second opinion.
#include "capture/c3d/check.h"
#include "cli/commands/commands.h"

namespace kinemesh::cli {
namespace {

struct Arguments {
  std::vector<std::string> files;
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

}  // namespace

CommandSpec c3d_check_command() {
  return {.path = "c3d check",
          .summary = "Say what is wrong in C3D files and what to do about it",
          .example = "kinemesh c3d check *.c3d",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positionals("FILE", args->files, "C3D files; TRC, CSV and TSV sessions too");
            line.parameters([args](ParameterSet& p) { args->check.declare(p); });
            line.json_output();
            return [args](Terminal& terminal) { return run_check(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
