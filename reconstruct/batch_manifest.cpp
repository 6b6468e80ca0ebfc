#include "reconstruct/batch_manifest.h"

#include <toml++/toml.h>
#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "capture/formats/table_text.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"
#include "mesh/formats/sequence.h"
#include "reconstruct/convert_files.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;

/// A session as the manifest names it.
struct ManifestRow {
  std::string session, output, topology;
  std::size_t line = 0;
};

struct Listing {
  std::string folder, extension, options_toml;
  std::vector<ManifestRow> rows;
};

[[noreturn]] void refuse(const fs::path& file, std::size_t line, const std::string& what,
                         const std::string& remedy = {}) {
  throw InputError({.what = what,
                    .file = file.string(),
                    .place = line > 0 ? "line " + std::to_string(line) : "",
                    .remedy = remedy});
}

std::size_t line_of(const toml::node& node) { return node.source().begin.line; }

std::string text_of(const fs::path& file, const std::string& key, const toml::node& node) {
  const auto text = node.value<std::string>();
  if (!text || !node.is_string()) refuse(file, line_of(node), "'" + key + "' must be a text");
  return *text;
}

[[noreturn]] void refuse_key(const fs::path& file, const std::string& key, const toml::node& node,
                             const std::vector<std::string>& known) {
  const std::string nearest = nearest_word(key, known);
  refuse(file, line_of(node), "unknown key '" + key + "'",
         nearest.empty() ? "Known are " + join(known, ", ", " and ")
                         : "Did you mean '" + nearest + "'?");
}

ManifestRow row_of(const fs::path& file, const toml::node& node) {
  const toml::table* table = node.as_table();
  if (table == nullptr) refuse(file, line_of(node), "a session must be a table, [[session]]");
  ManifestRow row{.line = line_of(node)};
  for (const auto& [key, value] : *table) {
    const std::string name(key.str());
    std::string* field = name == "session"    ? &row.session
                         : name == "output"   ? &row.output
                         : name == "topology" ? &row.topology
                                              : nullptr;
    if (field == nullptr) refuse_key(file, name, value, {"session", "output", "topology"});
    *field = text_of(file, name, value);
  }
  return row;
}

/// The lines of [options] and its tables as a document of its own, on the lines where they stand,
/// so that errors name them. Empty when that is not the same as `options`.
std::string options_in_place(const std::string& text, const toml::table& options) {
  std::istringstream lines(text);
  std::string out;
  bool inside = false;
  for (std::string line; std::getline(lines, line); out += '\n') {
    const std::string_view bare = trim(line);
    if (bare.starts_with('[')) {
      constexpr std::string_view begin = "[options.";
      inside = bare.starts_with(begin) || bare.starts_with("[options]");
      if (bare.starts_with(begin)) out += "[" + std::string(bare.substr(begin.size()));
    } else if (inside) {
      out += line;
    }
  }
  try {
    return toml::parse(out) == options ? out : "";
  } catch (const toml::parse_error&) {
    return "";
  }
}

Listing listing_of_toml(const fs::path& file, const std::string& text) {
  toml::table table;
  try {
    table = toml::parse(text);
  } catch (const toml::parse_error& e) {
    refuse(file, e.source().begin.line, "not valid TOML: " + std::string(e.description()));
  }
  Listing listing;
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (name == "output") {
      listing.folder = text_of(file, name, value);
    } else if (name == "extension") {
      listing.extension = text_of(file, name, value);
    } else if (name == "options" && value.is_table()) {
      std::ostringstream out;
      out << *value.as_table();
      const std::string in_place = options_in_place(text, *value.as_table());
      listing.options_toml = in_place.empty() ? out.str() : in_place;
    } else if (name == "session" && value.is_array()) {
      for (const toml::node& session : *value.as_array()) {
        listing.rows.push_back(row_of(file, session));
      }
    } else {
      refuse_key(file, name, value, {"output", "extension", "options", "session"});
    }
  }
  return listing;
}

Listing listing_of_csv(const fs::path& file, const std::string& text) {
  const TableText table(text, file.string());
  Listing listing;
  std::vector<std::string> columns;
  char separator = ',';
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (trim(table[i]).empty() || trim(table[i]).front() == '#') continue;
    if (columns.empty() && table[i].find(',') == std::string_view::npos &&
        table[i].find(';') != std::string_view::npos) {
      separator = ';';  // as spreadsheets write where the comma is the decimal sign
    }
    const std::vector<std::string> cells = split_cells(table[i], separator);
    if (columns.empty()) {
      columns = cells;
      const std::vector<std::string> known{"session", "output", "topology"};
      for (const std::string& column : columns) {
        if (std::ranges::find(known, column) == known.end()) {
          table.refuse(i, "unknown column '" + column + "'",
                       "The first line names the columns: session, output, topology");
        }
      }
      continue;
    }
    if (cells.size() > columns.size()) table.refuse(i, "more cells than columns");
    ManifestRow row{.line = i + 1};
    for (std::size_t c = 0; c < cells.size(); ++c) {
      (columns[c] == "session"  ? row.session
       : columns[c] == "output" ? row.output
                                : row.topology) = cells[c];
    }
    listing.rows.push_back(row);
  }
  return listing;
}

std::string key_of(const fs::path& path) { return fs::absolute(path).lexically_normal().string(); }

/// Outputs of different sessions, their other files included, must not meet.
std::map<std::string, std::size_t> index_outputs(const fs::path& file, const Listing& listing,
                                                 const std::vector<BatchSession>& sessions) {
  std::map<std::string, std::size_t> by_output;
  std::map<std::string, std::size_t> by_stem;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    by_output.emplace(key_of(sessions[i].output), i);
    fs::path output = sessions[i].output;
    std::string stem = key_of(output.replace_extension());
    while (stem.ends_with('#') || stem.ends_with('_')) stem.pop_back();  // a.ply and a_####.obj
    const auto [at, fresh] = by_stem.emplace(std::move(stem), i);
    if (!fresh) {
      refuse(file, listing.rows[i].line,
             "the output " + sessions[i].output.string() + " is also that of line " +
                 std::to_string(listing.rows[at->second].line),
             "Give one of them another 'output'");
    }
  }
  return by_output;
}

std::string canonical_of(const fs::path& path) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(fs::absolute(path), error);
  return error ? key_of(path) : real.lexically_normal().string();
}

/// Everything that a conversion to `output` may replace, by name; with `numbered` also the numbered
/// files that are there.
std::vector<fs::path> written_for(const fs::path& output, bool numbered) {
  std::vector<fs::path> all{output};
  fs::path stem = output;
  stem.replace_extension();
  std::string name = stem.string();
  for (const char* beside : {".ply", ".pc2", ".bin"}) {
    const std::string own = lower(output.extension().string());
    const bool belongs = std::string_view(beside) == ".bin"
                             ? own == ".gltf"
                             : own == ".ply" || own == ".pc2" || own == ".mdd";
    if (belongs) all.emplace_back(name + beside);
  }
  if (numbered) {
    const fs::path pattern =
        is_number_pattern(output) ? output : fs::path(name + "_####" + output.extension().string());
    for (const NumberedFile& file : matching_files(pattern)) all.push_back(file.path);
  }
  while (name.ends_with('#') || name.ends_with('_')) name.pop_back();
  for (const char* beside :
       {"_frames.png", "_gaps.png", "_quality.csv", "_report.html", "_summary.json"}) {
    all.emplace_back(name + beside);
  }
  return all;
}

/// What is read is never written over: neither by its own conversion nor by another one's.
void refuse_inputs_as_outputs(const fs::path& file, const std::vector<BatchSession>& sessions) {
  std::map<std::string, std::size_t> inputs;  // line by path
  for (const BatchSession& s : sessions) {
    inputs.emplace(canonical_of(s.session), s.line);
    if (!s.topology.empty() && !s.after) inputs.emplace(canonical_of(s.topology), s.line);
  }
  std::set<std::string> folders;
  for (const auto& [path, line] : inputs) folders.insert(fs::path(path).parent_path().string());
  for (const BatchSession& s : sessions) {
    const bool beside_inputs =
        folders.contains(fs::path(canonical_of(s.output)).parent_path().string());
    for (const fs::path& written : written_for(s.output, beside_inputs)) {
      const auto input = inputs.find(canonical_of(written));
      if (input == inputs.end()) continue;
      refuse(file, s.line,
             "the conversion to " + s.output.string() + " would replace " + written.string() +
                 ", which line " + std::to_string(input->second) + " reads",
             "Give it another 'output', or all of them another folder");
    }
  }
}

void refuse_circles(const fs::path& file, const Listing& listing,
                    const std::vector<BatchSession>& sessions) {
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    std::size_t steps = 0;
    for (auto at = sessions[i].after; at; at = sessions[*at].after) {
      if (++steps > sessions.size()) {
        refuse(file, listing.rows[i].line, "sessions wait for each other's topology in a circle");
      }
    }
  }
}

}  // namespace

BatchManifest read_batch_manifest(const fs::path& file, const BatchManifestOptions& options) {
  constexpr std::size_t largest = 64U << 20U;
  const std::string text = read_file(file, largest);
  const bool csv = lower(file.extension().string()) == ".csv";
  const Listing listing = csv ? listing_of_csv(file, text) : listing_of_toml(file, text);
  if (listing.rows.empty()) {
    refuse(file, 0, "the manifest names no session",
           csv ? "The first line names the columns (session, output, topology), each further line "
                 "is a session"
               : "Name each session in a table [[session]] with session = \"FILE.c3d\"");
  }
  BatchManifest manifest;
  manifest.file = file;
  manifest.options_toml = listing.options_toml;
  const fs::path base = file.parent_path();
  manifest.folder = !options.folder.empty()   ? fs::path(options.folder)
                    : !listing.folder.empty() ? base / listing.folder
                                              : base / (file.stem().string() + "_results");
  const std::string extension = listing.extension.empty() ? options.extension : listing.extension;
  for (const ManifestRow& row : listing.rows) {
    if (row.session.empty()) refuse(file, row.line, "a session without a file");
    const std::string name =
        row.output.empty() ? default_output(row.session, extension) : row.output;
    manifest.sessions.push_back(
        {.session = base / row.session, .output = manifest.folder / name, .line = row.line});
  }
  const auto by_output = index_outputs(file, listing, manifest.sessions);
  for (std::size_t i = 0; i < manifest.sessions.size(); ++i) {
    const std::string& name = listing.rows[i].topology;
    if (name.empty()) continue;
    BatchSession& session = manifest.sessions[i];
    const auto made = by_output.find(key_of(manifest.folder / name));
    if (made != by_output.end()) session.after = made->second;
    session.topology = made != by_output.end() ? manifest.folder / name : base / name;
  }
  refuse_circles(file, listing, manifest.sessions);
  refuse_inputs_as_outputs(file, manifest.sessions);
  return manifest;
}

}  // namespace kinemesh
