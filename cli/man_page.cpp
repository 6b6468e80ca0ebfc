// Man pages and bash completion, derived from the parser itself.
#include "cli/command_line.h"
#include "config/text.h"
#include "config/version.h"

namespace kinemesh::cli {
namespace {

/// Escapes troff's control characters.
std::string troff(const std::string& text) {
  std::string out;
  bool line_start = true;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      if (line_start && (c == '.' || c == '\'')) out += "\\&";
      out += c;
    }
    line_start = c == '\n';
  }
  return out;
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* o) { return !o->get_group().empty(); });
}

std::vector<const CLI::App*> subcommands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::string describe_options(const CLI::App& app) {
  std::string text;
  for (const CLI::Option* option : options_of(app)) {
    const std::string value = std::string(trim(option->get_option_text()));
    text += ".TP\n.B " + troff(shown_names(*option, option->get_positional()));
    text += value.empty() ? "\n" : " \\fI" + troff(value) + "\\fR\n";
    text += troff(option->get_description()) + "\n";
  }
  return text;
}

/// A case for each command, and the list of commands.
void complete(const CLI::App& app, const std::string& path, std::string& cases,
              std::vector<std::string>& paths) {
  std::vector<std::string> words;
  for (const CLI::App* sub : subcommands_of(app)) {
    words.push_back(sub->get_name());
    paths.push_back(path + (path.empty() ? "" : " ") + sub->get_name());
    complete(*sub, std::string(paths.back()), cases, paths);
  }
  for (const CLI::Option* option : options_of(app)) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
  cases += "    \"" + path + "\") words=\"" + join(words, " ") + "\" ;;\n";
}

}  // namespace

namespace {

/// "kinemesh c3d info".
std::string command_of(const Program& program, const CLI::App& app) {
  for (const Program::Entry& entry : program.entries) {
    if (entry.app == &app) return "kinemesh " + entry.spec.path;
  }
  return "kinemesh";
}

}  // namespace

std::string man_page(const Program& program, const CLI::App& app, const std::string& path) {
  std::string text =
      ".TH " + troff(upper(path)) + " 1 \"\" \"kinemesh " + version_number() + "\"\n";
  text += ".SH NAME\n" + troff(path) + " \\- " + troff(app.get_description()) + "\n";
  text += ".SH SYNOPSIS\n.B " + troff(command_of(program, app)) + "\n";
  for (const CLI::Option* option : options_of(app)) {
    if (option->get_positional()) text += "\\fI" + troff(option->get_name(true)) + "\\fR\n";
  }
  text += "[\\fIOPTIONS\\fR]\n";
  if (&app == &program.app) {
    text += ".SH COMMANDS\n";
    for (const Program::Entry& entry : program.entries) {
      text += ".TP\n.B " + troff(entry.spec.path) + "\n" + troff(entry.spec.summary) + "\n";
    }
  }
  text += ".SH OPTIONS\n" + describe_options(app);
  text += ".SH NOTES\n.nf\n" + troff(app.get_footer()) + "\n.fi\n";
  return text;
}

std::string bash_completion(const Program& program) {
  std::string cases;
  std::vector<std::string> paths;
  complete(program.app, "", cases, paths);
  return "# bash completion for kinemesh, generated from its own command line\n"
         "_kinemesh() {\n"
         "  local current=\"${COMP_WORDS[COMP_CWORD]}\" path=\"\" words=\"\" i\n"
         "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
         "    case \"${path:+$path }${COMP_WORDS[i]}\" in\n"
         "    \"" +
         join(paths, "\" | \"") +
         "\")\n"
         "      path=\"${path:+$path }${COMP_WORDS[i]}\" ;;\n"
         "    esac\n"
         "  done\n"
         "  case \"$path\" in\n" +
         cases +
         "  esac\n"
         "  mapfile -t COMPREPLY < <(\n"
         "    compgen -W \"$words\" -- \"$current\"\n"
         "    [[ $current == -* ]] || compgen -f -- \"$current\")\n"
         "}\n"
         "complete -o filenames -F _kinemesh kinemesh\n";
}

}  // namespace kinemesh::cli
