// The CLI11 side of CommandLine. Only the .cpp files of cli/ that parse, and those that write man
// pages and completion, include this.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cli/command.h"

namespace kinemesh::cli {

/// Options that every subcommand takes.
struct CommonOptions {
  int threads = 0;
  int64_t seed = 0;
  bool quiet = false;
  bool verbose = false;
  bool json = false;
};

class Cli11CommandLine : public CommandLine {
 public:
  /// `command` is the path of the subcommand, for messages.
  Cli11CommandLine(CLI::App& app, std::string command);
  void positional(const std::string& name, std::string& field, const std::string& help) override;
  void optional_positional(const std::string& name, std::string& field,
                           const std::string& help) override;
  void positionals(const std::string& name, std::vector<std::string>& field,
                   const std::string& help) override;
  void option(const std::string& names, std::string& field, const std::string& metavar,
              const std::string& help, bool required) override;
  void option(const std::string& names, std::vector<std::string>& field, const std::string& metavar,
              const std::string& help) override;
  void words(const std::string& names, std::vector<std::string>& field, const std::string& metavar,
             const std::string& help, bool required) override;
  void flag(const std::string& names, bool& field, const std::string& help) override;
  void parameters(std::function<void(ParameterSet&)> declare,
                  std::function<ConfigText()> base) override;
  void json_output() override;

  const CommonOptions& common() const { return common_; }
  /// Sets the parameters from --config and then from the command line.
  void apply_parameters();
  /// Throws UsageError naming what must be given and was not. Not asked by --dump-config.
  void check_required() const;
  /// Throws UsageError for a file or name that is given as nothing ("-o ''").
  void check_not_empty() const;
  bool dump_config() const { return dump_config_; }
  std::string options_toml() const;
  CLI::App& app() { return app_; }

 private:
  void add_parameter(Parameter& parameter);
  void require(CLI::Option* option) { required_.push_back(option); }

  CLI::App& app_;
  std::string command_;
  std::vector<const CLI::Option*> required_;
  std::vector<const CLI::Option*> never_empty_;
  CommonOptions common_;
  ParameterSet set_;
  std::map<std::string, std::vector<std::string>> given_;  // by parameter name
  std::function<ConfigText()> base_;
  std::string config_file_;
  bool dump_config_ = false;
};

/// The whole program's parser: every subcommand set up.
struct Program {
  struct Entry {
    CommandSpec spec;
    CLI::App* app = nullptr;
    std::unique_ptr<Cli11CommandLine> line;
    Action action;
  };
  Program();
  CLI::App app;
  std::vector<Entry> entries;
  bool version = false;
};

/// "--stabilise,--no-stabilise" as help and man pages show it. CLI11 alone adds the value that a
/// negated flag stands for in braces, which nobody is to type.
std::string shown_names(const CLI::Option& option, bool positional);

/// Help as CLI11 lays it out, with shown_names().
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_name(const CLI::Option* option, bool positional) const override {
    return shown_names(*option, positional);
  }
};

/// A man page (troff) of the program, or of one command of it.
std::string man_page(const Program& program, const CLI::App& app, const std::string& path);
/// The bash completion script.
std::string bash_completion(const Program& program);

}  // namespace kinemesh::cli
