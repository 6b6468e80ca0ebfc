#include "mesh/formats/metadata.h"

#include <algorithm>
#include <charconv>

#include "config/text.h"

namespace kinemesh {
namespace {

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    switch (c) {
      case '"': out += "\\\""; break;
      case '\\': out += "\\\\"; break;
      case '\n': out += "\\n"; break;
      case '\r': out += "\\r"; break;
      case '\t': out += "\\t"; break;
      default: out += c;
    }
  }
  return out + '"';
}

/// Splits a line into words; quoted ones are unescaped.
std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < line.size();) {
    if (line[i] == ' ' || line[i] == '\t') {
      ++i;
      continue;
    }
    std::string word;
    if (line[i] != '"') {
      while (i < line.size() && line[i] != ' ' && line[i] != '\t') word += line[i++];
    } else {
      for (++i; i < line.size() && line[i] != '"'; ++i) {
        if (line[i] != '\\' || i + 1 == line.size()) {
          word += line[i];
          continue;
        }
        const char c = line[++i];
        word += c == 'n' ? '\n' : c == 'r' ? '\r' : c == 't' ? '\t' : c;
      }
      ++i;
    }
    words.push_back(std::move(word));
  }
  return words;
}

template <class T>
bool parse(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

template <class T>
std::string number(T value) {
  std::string out;
  append_number(out, value);
  return out;
}

/// Readers of PLY give up at longer lines (VTK's at 4,096 bytes, RPly at 1,024).
constexpr std::size_t longest_piece = 400;

/// Bytes of `text` that fit on one line: whole lines of it if possible, and whole characters.
std::size_t piece_of(std::string_view text) {
  if (text.size() <= longest_piece) return text.size();
  const std::size_t line_end = text.rfind('\n', longest_piece - 1);
  if (line_end != std::string_view::npos) return line_end + 1;
  std::size_t end = longest_piece;
  while (end > 1 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return end;
}

void add_provenance(const Provenance& provenance, std::vector<std::string>& lines) {
  const auto add = [&lines](const char* key, std::string_view value) {
    for (std::string mark = " "; !value.empty(); mark = "+ ") {
      const std::size_t piece = piece_of(value);
      lines.push_back("kinemesh " + (key + mark) + in_quotes(value.substr(0, piece)));
      value.remove_prefix(piece);
    }
  };
  add("program", provenance.program);
  add("command", provenance.command);
  add("options", provenance.options);
  add("source", provenance.source);
  for (const Provenance::Input& input : provenance.inputs) {
    lines.push_back("kinemesh input " + in_quotes(input.path) + " " + in_quotes(input.sha256));
  }
}

void add_filled_runs(const AnimatedMesh& mesh, std::vector<std::string>& lines) {
  const std::size_t vertices = mesh.vertex_count();
  const auto filled = mesh.filled();
  lines.emplace_back("kinemesh filled_known");
  for (std::size_t v = 0; v < vertices; ++v) {
    std::string line;
    for (std::size_t f = 0; f < mesh.frame_count();) {
      std::size_t end = f;
      while (end < mesh.frame_count() && filled[end * vertices + v] != 0) ++end;
      if (end > f) line += " " + std::to_string(f) + "-" + std::to_string(end - 1);
      f = end + 1;
      if (line.empty() || (f < mesh.frame_count() && line.size() < longest_piece)) continue;
      lines.push_back("kinemesh filled " + std::to_string(v) + line);
      line.clear();
    }
  }
}

void add_uncertainty(const AnimatedMesh& mesh, double to_mm, std::vector<std::string>& lines) {
  const std::size_t vertices = mesh.vertex_count();
  const auto sd = mesh.uncertainty();
  lines.emplace_back("kinemesh uncertainty_known");
  for (std::size_t v = 0; v < vertices; ++v) {
    std::string line;
    for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
      const float value = sd[f * vertices + v];
      if (value > 0.0F) {
        if (line.empty()) line = std::to_string(v) + " " + std::to_string(f);
        append_number(line += ' ', static_cast<float>(to_mm * value));
      }
      const bool ends = !(value > 0.0F) || f + 1 == mesh.frame_count();
      if (line.empty() || (!ends && line.size() < longest_piece)) continue;
      lines.push_back("kinemesh uncertainty " + line);
      line.clear();
    }
  }
}

}  // namespace

std::vector<std::string> metadata_lines(const AnimatedMesh& mesh, std::size_t frame,
                                        const WriteOptions& options, const MetadataChoice& choice) {
  std::vector<std::string> lines;
  lines.push_back("kinemesh unit " + in_quotes(name_of(options.unit)));
  if (mesh.rate_hz > 0) lines.push_back("kinemesh rate_hz " + number(mesh.rate_hz));
  lines.push_back("kinemesh first_frame " + number(mesh.first_frame + static_cast<int64_t>(frame)));
  if (choice.description) {
    for (std::size_t v = 0; v < mesh.vertex_names.size(); ++v) {
      lines.push_back("kinemesh vertex_name " + std::to_string(v) + " " +
                      in_quotes(mesh.vertex_names[v]));
    }
    for (const Event& event : mesh.events) {
      lines.push_back("kinemesh event " + number(event.time_s) + " " + in_quotes(event.label) +
                      " " + in_quotes(event.context) + " " + in_quotes(event.subject));
    }
    add_provenance(mesh.provenance, lines);
  }
  if (choice.filled_runs && !mesh.filled().empty()) add_filled_runs(mesh, lines);
  if (choice.uncertainty && !mesh.uncertainty().empty()) add_uncertainty(mesh, choice.to_mm, lines);
  return lines;
}

std::string* MetadataReader::provenance_text(std::string_view key) {
  if (key.ends_with('+')) key.remove_suffix(1);
  Provenance& found = found_.provenance;
  return key == "program"   ? &found.program
         : key == "command" ? &found.command
         : key == "options" ? &found.options
         : key == "source"  ? &found.source
                            : nullptr;
}

void MetadataReader::read_uncertainty(const std::vector<std::string>& words) {
  UncertaintyRun run;
  if (words.size() < 4 || !parse(words[1], run.vertex) || !parse(words[2], run.first)) return;
  for (std::size_t i = 3; i < words.size(); ++i) {
    float mm = 0.0F;
    if (!parse(words[i], mm) || !(mm >= 0.0F && mm <= 1e9F)) return;
    run.mm.push_back(mm);
  }
  found_.uncertainty_runs->push_back(std::move(run));
}

void MetadataReader::read(std::string_view line) {
  if (!line.starts_with("kinemesh ")) return;
  const std::vector<std::string> words = words_of(line.substr(9));
  if (words.empty()) return;
  const std::string& key = words[0];
  if (key == "filled_known" && !found_.filled_runs) found_.filled_runs.emplace();
  if (key == "uncertainty_known" && !found_.uncertainty_runs) found_.uncertainty_runs.emplace();
  if (words.size() < 2) return;
  const std::string& value = words[1];
  int64_t integer = 0;
  double real = 0.0;
  std::size_t vertex = 0;
  if (key == "unit") {
    found_.unit = length_unit_of(value);
  } else if (key == "rate_hz" && parse(value, real) && real > 0 && real < 1e9) {
    found_.rate_hz = real;
  } else if (key == "first_frame" && parse(value, integer)) {
    found_.first_frame = integer;
  } else if (key == "vertex_name" && words.size() > 2 && parse(value, vertex)) {
    names_.emplace_back(vertex, words[2]);
  } else if (key == "event" && words.size() > 4 && parse(value, real)) {
    found_.events.push_back({words[2], words[3], words[4], real});
  } else if (key == "input" && words.size() > 2) {
    found_.provenance.inputs.push_back({value, words[2]});
  } else if (std::string* text = provenance_text(key)) {
    key.ends_with('+') ? text->append(value) : text->assign(value);
  } else if (key == "uncertainty" && found_.uncertainty_runs) {
    read_uncertainty(words);
  } else if (key == "filled" && found_.filled_runs && parse(value, vertex)) {
    for (std::size_t i = 2; i < words.size(); ++i) {
      const std::size_t dash = words[i].find('-');
      FilledRun run{vertex, 0, 0};
      if (dash != std::string::npos &&
          parse(std::string_view(words[i]).substr(0, dash), run.first) &&
          parse(std::string_view(words[i]).substr(dash + 1), run.last)) {
        found_.filled_runs->push_back(run);
      }
    }
  }
}

void MetadataReader::apply(MeshData& data) const {
  if (found_.unit) data.unit = found_.unit;
  if (found_.rate_hz > 0) data.rate_hz = found_.rate_hz;
  if (found_.first_frame) data.first_frame = found_.first_frame;
  if (!found_.events.empty()) data.events = found_.events;
  data.provenance = found_.provenance;
  if (!names_.empty() && data.vertex_names.empty()) {
    data.vertex_names.resize(data.vertex_count);
    for (const auto& [vertex, name] : names_) {
      if (vertex < data.vertex_count) data.vertex_names[vertex] = name;
    }
  }
  if (found_.filled_runs) data.filled_runs = found_.filled_runs;
  if (found_.uncertainty_runs) data.uncertainty_runs = found_.uncertainty_runs;
}

}  // namespace kinemesh
