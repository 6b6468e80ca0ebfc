// How a subcommand is written: it declares its arguments on a CommandLine and returns the action
// to run. Parsing, help, --config, --dump-config, logging, progress, Ctrl-C, exit codes, man pages
// and completion come from here.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/error.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh::cli {

/// What an action gets: the run context, and where its output goes.
struct Terminal {
  RunContext run;            ///< threads, seed, log and progress set from the command line
  bool json = false;         ///< --json was given: print one JSON document on stdout, nothing else
  bool quiet = false;        ///< -q was given: files are written, nothing is told but errors
  std::string command_line;  ///< as typed, quoted so that a shell reads it back alike
  std::string options_toml;  ///< the effective parameters, as --dump-config prints them

  /// Prints on stdout, adding a newline when there is none. Throws InputError when it is closed.
  void print(std::string_view text) const;
};

/// A TOML document and where it is from, for errors.
struct ConfigText {
  std::string toml, origin;
};

using Action = std::function<ExitCode(Terminal&)>;

/// The arguments of one subcommand. Fields are bound by reference and must outlive parsing: keep
/// them in a shared_ptr that the action captures.
class CommandLine {
 public:
  virtual ~CommandLine() = default;
  /// A required positional argument.
  virtual void positional(const std::string& name, std::string& field, const std::string& help) = 0;
  /// An optional positional argument.
  virtual void optional_positional(const std::string& name, std::string& field,
                                   const std::string& help) = 0;
  /// One or more positional arguments.
  virtual void positionals(const std::string& name, std::vector<std::string>& field,
                           const std::string& help) = 0;
  /// An option with a value, such as "-o,--output". `required` ones must be given.
  virtual void option(const std::string& names, std::string& field, const std::string& metavar,
                      const std::string& help, bool required = false) = 0;
  /// An option that may be given several times.
  virtual void option(const std::string& names, std::vector<std::string>& field,
                      const std::string& metavar, const std::string& help) = 0;
  /// An option that takes one or more words ("--from 3 17 99" or "--from 3,17,99").
  virtual void words(const std::string& names, std::vector<std::string>& field,
                     const std::string& metavar, const std::string& help,
                     bool required = false) = 0;
  virtual void flag(const std::string& names, bool& field, const std::string& help) = 0;
  /// Adds all parameters that `declare` declares, as --NAME options, and with them --config and
  /// --dump-config. They are set before the action runs: first from the file, then from the
  /// command line. Call it once, with one function that declares every options struct.
  /// `base` may give a document that holds where neither says anything else.
  virtual void parameters(std::function<void(ParameterSet&)> declare,
                          std::function<ConfigText()> base = {}) = 0;
  /// Offers --json.
  virtual void json_output() = 0;
};

/// One subcommand.
struct CommandSpec {
  std::string path;     ///< words of the command: "convert", "c3d info"
  std::string summary;  ///< one line, without a full stop
  std::string example;  ///< one or more command lines, separated by newlines
  std::function<Action(CommandLine&)> setup;
};

/// All subcommands, in the order of the help. A new command is one .cpp and one line here.
std::vector<CommandSpec> all_commands();
/// One line about the commands that share a first word: "c3d", "evaluate".
std::string family_summary(std::string_view family);

/// Parses the arguments, runs the command and returns the process' exit code.
int run_program(int argc, char** argv);

}  // namespace kinemesh::cli
