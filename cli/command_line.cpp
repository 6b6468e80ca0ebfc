#include "cli/command_line.h"

#include <limits>

#include "config/input_file.h"
#include "config/text.h"

namespace kinemesh::cli {
namespace {

constexpr const char* general_group = "General";

std::string upper_metavar(const Parameter& p) {
  switch (p.kind()) {
    case Parameter::Kind::integer:
    case Parameter::Kind::number: return p.unit().empty() ? "NUMBER" : p.unit();
    case Parameter::Kind::choice: return "WORD";
    default: return p.metavar();
  }
}

/// Help as shown beside an option: meaning, what is allowed, default.
std::string help_of(const Parameter& p) {
  std::string text = p.help();
  const std::string standard = join(p.get(), ",");
  if (p.kind() == Parameter::Kind::boolean) {
    return text + (standard == "true" ? " (default: yes)" : "");
  }
  std::vector<std::string> notes;
  if (p.kind() == Parameter::Kind::choice) {
    for (const ChoiceWord& w : p.words()) notes.push_back(w.word + ": " + w.help);
    text += ". " + join(notes, "; ");
    notes.clear();
  } else if (p.kind() != Parameter::Kind::text && p.kind() != Parameter::Kind::text_list) {
    notes.push_back(p.allowed());
  }
  if (!standard.empty()) notes.push_back("default " + standard);
  return notes.empty() ? text : text + " (" + join(notes, "; ") + ")";
}

}  // namespace

Cli11CommandLine::Cli11CommandLine(CLI::App& app, std::string command)
    : app_(app), command_(std::move(command)) {
  app_.add_option("--threads", common_.threads, "Threads to use; 0 means all of the machine's")
      ->check(CLI::Range(0, 1024))
      ->option_text("N")
      ->group(general_group);
  app_.add_option("--seed", common_.seed,
                  "Seed of random choices; the same seed gives the same result")
      ->check(CLI::Range(int64_t{0}, std::numeric_limits<int64_t>::max()))
      ->option_text("N")
      ->group(general_group);
  auto* quiet =
      app_.add_flag("-q,--quiet", common_.quiet, "Show errors only")->group(general_group);
  app_.add_flag("-v,--verbose", common_.verbose, "Show details")
      ->group(general_group)
      ->excludes(quiet);
}

void Cli11CommandLine::positional(const std::string& name, std::string& field,
                                  const std::string& help) {
  CLI::Option* option = app_.add_option(name, field, help)->option_text(" ");
  require(option);
  never_empty_.push_back(option);
}

void Cli11CommandLine::optional_positional(const std::string& name, std::string& field,
                                           const std::string& help) {
  app_.add_option(name, field, help)->option_text(" ");
}

void Cli11CommandLine::positionals(const std::string& name, std::vector<std::string>& field,
                                   const std::string& help) {
  require(app_.add_option(name, field, help)->option_text("..."));
}

void Cli11CommandLine::option(const std::string& names, std::string& field,
                              const std::string& metavar, const std::string& help, bool required) {
  CLI::Option* option = app_.add_option(names, field, help)->option_text(metavar);
  if (required) require(option);
  never_empty_.push_back(option);
}

void Cli11CommandLine::option(const std::string& names, std::vector<std::string>& field,
                              const std::string& metavar, const std::string& help) {
  app_.add_option(names, field, help)->option_text(metavar)->allow_extra_args(false);
}

void Cli11CommandLine::words(const std::string& names, std::vector<std::string>& field,
                             const std::string& metavar, const std::string& help, bool required) {
  CLI::Option* option =
      app_.add_option(names, field, help)->option_text(metavar + " ...")->delimiter(',');
  if (required) require(option);
}

void Cli11CommandLine::flag(const std::string& names, bool& field, const std::string& help) {
  app_.add_flag(names, field, help);
}

void Cli11CommandLine::json_output() {
  app_.add_flag("--json", common_.json, "Print the result as one JSON document")
      ->group(general_group);
}

void Cli11CommandLine::parameters(std::function<void(ParameterSet&)> declare,
                                  std::function<ConfigText()> base) {
  base_ = std::move(base);
  declare(set_);
  for (Parameter& p : set_.parameters()) add_parameter(p);
  app_.add_option("--config", config_file_, "Read options from this file; the command line wins")
      ->option_text("FILE.toml")
      ->group(general_group);
  app_.add_flag("--dump-config", dump_config_, "Print all options as TOML, and do nothing else")
      ->group(general_group);
}

void Cli11CommandLine::add_parameter(Parameter& p) {
  const std::string& title = set_.title(p.group());
  const std::string heading = title.empty() ? "Options" : title;
  const std::string& name = p.name();
  if (p.kind() == Parameter::Kind::boolean) {
    app_.add_flag_function(
            "--" + name + ",!--no-" + name,
            [this, name](int64_t count) { given_[name] = {count > 0 ? "true" : "false"}; },
            help_of(p))
        ->group(heading);
    return;
  }
  CLI::Option* option =
      app_.add_option_function<std::vector<std::string>>(
              "--" + name,
              [this, name](const std::vector<std::string>& values) { given_[name] = values; },
              help_of(p))
          ->option_text(upper_metavar(p))
          ->group(heading)
          ->allow_extra_args(false);
  if (p.kind() == Parameter::Kind::text_list) {
    option->delimiter(',');
  } else {
    option->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }
}

void Cli11CommandLine::check_required() const {
  for (const CLI::Option* option : required_) {
    if (option->count() > 0) continue;
    throw UsageError({.what = option->get_name() + " is required",
                      .remedy = "See 'kinemesh " + command_ + " --help'"});
  }
}

void Cli11CommandLine::check_not_empty() const {
  for (const CLI::Option* option : never_empty_) {
    if (option->count() == 0 || !option->results().back().empty()) continue;
    throw UsageError({.what = option->get_name() + " is given, but empty",
                      .remedy = "Give a name, or leave it out"});
  }
}

void Cli11CommandLine::apply_parameters() {
  if (base_) {
    const ConfigText text = base_();
    set_.load_toml(text.toml, text.origin);
  }
  if (!config_file_.empty()) set_.load_toml(read_file(config_file_, 1U << 24U), config_file_);
  for (const auto& [name, values] : given_) {
    try {
      set_.find(name)->set(values);
    } catch (const UsageError& e) {
      throw UsageError({.what = "--" + name + ": " + e.details().what});
    }
  }
}

std::string shown_names(const CLI::Option& option, bool positional) {
  std::string names = option.get_name(positional, !positional);
  constexpr std::string_view value = "{false}";
  for (std::size_t at = names.find(value); at != std::string::npos; at = names.find(value, at)) {
    names.erase(at, value.size());
  }
  return names;
}

std::string Cli11CommandLine::options_toml() const { return set_.dump_toml(); }

}  // namespace kinemesh::cli
