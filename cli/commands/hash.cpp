// kinemesh hash: the hash by which outputs name their inputs.
#include "cli/commands/commands.h"
#include "config/input_file.h"

namespace kinemesh::cli {

CommandSpec hash_command() {
  return {.path = "hash",
          .summary = "Print the SHA-256 of files, as recorded in outputs that were made from them",
          .example = "kinemesh hash session.c3d",
          .setup = [](CommandLine& line) -> Action {
            auto files = std::make_shared<std::vector<std::string>>();
            line.positionals("FILE", *files, "Files to hash");
            return [files](Terminal& terminal) {
              for (const std::string& file : *files) {
                terminal.print(sha256_of_file(file) + "  " + file);
              }
              return ExitCode::done;
            };
          }};
}

}  // namespace kinemesh::cli
