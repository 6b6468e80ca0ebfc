// Building the parser from all_commands(), and running one command of it.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "cli/command_line.h"
#include "cli/console.h"
#include "config/text.h"
#include "config/version.h"

namespace kinemesh::cli {
namespace {

/// The context that Ctrl-C cancels. A signal handler can reach nothing but a global.
const RunContext* interrupted_context = nullptr;

void on_interrupt(int) {
  if (interrupted_context != nullptr) interrupted_context->cancel();
}

class InterruptGuard {
 public:
  explicit InterruptGuard(const RunContext& context) {
    interrupted_context = &context;
    struct sigaction action {};
    action.sa_handler = on_interrupt;
    action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second Ctrl-C ends the program at once
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
  }
  ~InterruptGuard() {
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
    interrupted_context = nullptr;
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
};

std::string shell_quote(const std::string& word) {
  constexpr std::string_view safe =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=+,@%^-";
  if (!word.empty() && word.find_first_not_of(safe) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

std::string command_line_of(int argc, char** argv) {
  std::string line = "kinemesh";
  for (int i = 1; i < argc; ++i) line += " " + shell_quote(argv[i]);
  return line;
}

/// Parent of a command of two words, created on first use.
CLI::App* parent_of(CLI::App& app, const std::string& path, std::string& name) {
  const auto blank = path.find(' ');
  if (blank == std::string::npos) {
    name = path;
    return &app;
  }
  name = path.substr(blank + 1);
  const std::string family = path.substr(0, blank);
  const auto same_name = [&](const CLI::App* sub) { return sub->get_name() == family; };
  const auto known = app.get_subcommands(same_name);
  if (!known.empty()) return known.front();
  CLI::App* parent = app.add_subcommand(family, family_summary(family));
  parent->require_subcommand(1);
  return parent;
}

std::string indent_lines(const std::string& text) {
  std::string out = "  ";
  for (const char c : text) {
    out += c;
    if (c == '\n') out += "  ";
  }
  return out;
}

ExitCode run_entry(Program::Entry& entry, const std::string& command_line, Console& console) {
  Terminal terminal;
  const CommonOptions& common = entry.line->common();
  terminal.run.set_threads(common.threads).set_seed(static_cast<uint64_t>(common.seed));
  terminal.json = common.json;
  terminal.command_line = command_line;
  console.attach(terminal.run);
  entry.line->apply_parameters();
  terminal.options_toml = entry.line->options_toml();
  if (entry.line->dump_config()) {
    terminal.print(terminal.options_toml);
    return ExitCode::done;
  }
  const InterruptGuard guard(terminal.run);
  return entry.action(terminal);
}

int run_guarded(Program::Entry& entry, const std::string& command_line) {
  const CommonOptions& common = entry.line->common();
  Console console(common.quiet     ? Verbosity::quiet
                  : common.verbose ? Verbosity::verbose
                                   : Verbosity::normal);
  try {
    return static_cast<int>(run_entry(entry, command_line, console));
  } catch (const CancelledError&) {
    console.error("cancelled; nothing was written");
    return static_cast<int>(ExitCode::cancelled);
  } catch (const Error& e) {
    console.error(e.what());
    return static_cast<int>(e.exit_code());
  } catch (const std::bad_alloc&) {
    console.error("not enough memory for this input");
  } catch (const std::exception& e) {
    console.error(std::string("internal error: ") + e.what());
  }
  return static_cast<int>(ExitCode::internal_error);
}

/// Generation of man pages and completion at build time; hidden from the help.
bool generate(const Program& program, int argc, char** argv) {
  if (argc != 4 || std::string_view(argv[1]) != "--generate") return false;
  const std::string what = argv[2];
  const std::string folder = argv[3];
  const auto write = [&folder](const std::string& name, const std::string& text) {
    std::FILE* file = std::fopen((folder + "/" + name).c_str(), "wb");
    if (file == nullptr || std::fwrite(text.data(), 1, text.size(), file) != text.size() ||
        std::fclose(file) != 0) {
      throw InputError({.what = "cannot write", .file = folder + "/" + name});
    }
  };
  if (what == "completion") write("kinemesh", bash_completion(program));
  if (what == "man") {
    write("kinemesh.1", man_page(program, program.app, "kinemesh"));
    for (const Program::Entry& entry : program.entries) {
      std::string path = "kinemesh-" + entry.spec.path;
      std::ranges::replace(path, ' ', '-');
      write(path + ".1", man_page(program, *entry.app, path));
    }
  }
  return true;
}

int report_usage(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help
  std::fprintf(stderr, "kinemesh: error: %s\nSee 'kinemesh --help' or 'kinemesh COMMAND --help'.\n",
               error.what());
  return static_cast<int>(ExitCode::usage);
}

}  // namespace

void Terminal::print(std::string_view text) const {
  const bool newline = text.empty() || text.back() != '\n';
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
      (newline && std::fputc('\n', stdout) == EOF) || std::fflush(stdout) != 0) {
    throw InputError({.what = "cannot write", .file = "standard output"});
  }
}

Program::Program()
    : app("Kinemesh turns motion-capture sessions into animated meshes and compares how they move.",
          "kinemesh") {
  app.footer(
      "Examples:\n  kinemesh convert session.c3d -o face.ply\n  kinemesh c3d info session.c3d\n\n"
      "Exit codes: 0 done, 1 internal error, 2 wrong usage, 3 unreadable or invalid input,\n"
      "4 the data allow no result, 130 cancelled.");
  app.require_subcommand(0, 1);
  app.get_formatter()->column_width(34);
  app.add_flag("--version", version, "Print version, commit and libraries");
  for (CommandSpec& spec : all_commands()) {
    std::string name;
    CLI::App* parent = parent_of(app, spec.path, name);
    CLI::App* sub = parent->add_subcommand(name, spec.summary);
    sub->footer("Example:\n" + indent_lines(spec.example));
    auto line = std::make_unique<Cli11CommandLine>(*sub);
    Action action = spec.setup(*line);
    entries.push_back({std::move(spec), sub, std::move(line), std::move(action)});
  }
}

int run_program(int argc, char** argv) {
  try {
    Program program;
    if (generate(program, argc, argv)) return 0;
    try {
      program.app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
      return report_usage(program.app, e);
    }
    if (program.version) {
      std::printf("%s\n", program_version().c_str());
      return 0;
    }
    const std::string command_line = command_line_of(argc, argv);
    for (Program::Entry& entry : program.entries) {
      if (entry.app->parsed()) return run_guarded(entry, command_line);
    }
    std::printf("%s", program.app.help().c_str());
    return static_cast<int>(ExitCode::usage);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "kinemesh: error: %s\n", e.what());
    return static_cast<int>(ExitCode::internal_error);
  }
}

}  // namespace kinemesh::cli
