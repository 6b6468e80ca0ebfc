// kinemesh formats: what is read and written, and what each format loses.
#include <nlohmann/json.hpp>

#include "capture/formats/mesh_formats.h"
#include "cli/commands/commands.h"
#include "config/text.h"

namespace kinemesh::cli {
namespace {

std::string capability(const Format& format) {
  if (format.can_read() && format.can_write()) return "read, write";
  return format.can_read() ? "read" : "write";
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

std::string formats_text(const FormatRegistry& registry) {
  std::string out;
  for (const Format& format : registry.formats()) {
    const std::string lost = format.loses();
    out += padded(format.name, 9) + padded(join(format.extensions, " "), 7) +
           padded(capability(format), 13) + format.description + "\n";
    out += std::string(29, ' ') + "exactness: " + format.exactness + "\n";
    out += std::string(29, ' ') + "loses: " + (lost.empty() ? "nothing" : lost) + "\n";
  }
  return out;
}

nlohmann::ordered_json formats_json(const FormatRegistry& registry) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Format& format : registry.formats()) {
    const Keeps& k = format.keeps;
    all.push_back({{"name", format.name},
                   {"extensions", format.extensions},
                   {"description", format.description},
                   {"read", format.can_read()},
                   {"write", format.can_write()},
                   {"numbered_sequence", format.single_frame},
                   {"exactness", format.exactness},
                   {"keeps",
                    {{"faces", k.faces},
                     {"names", k.names},
                     {"unit", k.unit},
                     {"rate", k.rate},
                     {"first_frame", k.first_frame},
                     {"events", k.events},
                     {"filled", k.filled},
                     {"uncertainty", k.uncertainty},
                     {"provenance", k.provenance}}}});
  }
  return {{"formats", all}};
}

}  // namespace

CommandSpec formats_command() {
  return {
      .path = "formats",
      .summary = "List the file formats that are read and written, and what each loses",
      .example = "kinemesh formats\nkinemesh formats --json",
      .setup = [](CommandLine& line) -> Action {
        line.json_output();
        return [](Terminal& terminal) {
          const FormatRegistry registry = all_formats();
          terminal.print(terminal.json ? formats_json(registry).dump(2) : formats_text(registry));
          return ExitCode::done;
        };
      }};
}

}  // namespace kinemesh::cli
