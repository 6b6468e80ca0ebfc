#include "capture/formats/trc.h"

#include <algorithm>
#include <map>

#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using TrcHeader = std::map<std::string, std::string, std::less<>>;

/// First line at or behind `from` whose first cell is `word`, or npos.
std::size_t find_line(const TableText& text, std::size_t from, std::string_view word) {
  for (std::size_t line = from; line < text.size() && line < 64; ++line) {
    if (lower(trim(text[line])).starts_with(word)) return line;
  }
  return std::string::npos;
}

TrcHeader read_header(const TableText& text, std::size_t keys_line, char separator) {
  // Some programs put two tabs between values: names and values are paired without blanks.
  const auto words = [&](std::size_t line) {
    std::vector<std::string> kept;
    for (std::string& cell : split_cells(text[line], separator)) {
      if (!cell.empty()) kept.push_back(std::move(cell));
    }
    return kept;
  };
  const std::vector<std::string> keys = words(keys_line);
  const std::vector<std::string> values = words(keys_line + 1);
  if (values.size() < keys.size() && values.size() < 5) {
    text.refuse(keys_line + 1, "there are fewer values than names in the line above");
  }
  TrcHeader header;
  for (std::size_t i = 0; i < std::min(keys.size(), values.size()); ++i) {
    header.emplace(lower(keys[i]), values[i]);
  }
  return header;
}

double number_of(const TableText& text, const TrcHeader& header, std::string_view key,
                 std::size_t line) {
  const auto it = header.find(key);
  if (it == header.end()) return 0.0;
  const std::optional<double> value = parse_cell(it->second);
  if (!value || !(*value >= 0) || *value > 1e12) {
    text.refuse(line, "'" + it->second + "' is no valid " + std::string(key));
  }
  return *value;
}

/// Labels above every third column, or side by side when the program left the blanks out.
std::vector<std::string> read_labels(const TableText& text, std::size_t line, char separator,
                                     std::size_t declared) {
  std::vector<std::string> cells = split_cells(text[line], separator);
  cells.erase(cells.begin(), cells.begin() + std::min<std::ptrdiff_t>(2, std::ssize(cells)));
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  std::vector<std::string> packed;
  bool in_place = true;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].empty()) continue;
    in_place = in_place && i % 3 == 0;
    packed.push_back(cells[i]);
  }
  if (!in_place || (packed.size() == cells.size() && cells.size() > 1)) return packed;
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < cells.size(); i += 3) labels.push_back(cells[i]);
  // Markers without a name at the end leave nothing to see: the header has their number.
  if (declared > labels.size() && declared < labels.size() + 10000) labels.resize(declared);
  return labels;
}

}  // namespace

MarkerSequence read_trc(const TableText& text, const TableReadOptions& options,
                        const RunContext& ctx) {
  const std::size_t keys_line = find_line(text, 0, "datarate");
  const std::size_t labels_line = find_line(text, 0, "frame#");
  if (keys_line == std::string::npos || keys_line + 1 >= text.size()) {
    text.refuse(0, "this is no TRC file: the line that begins with DataRate is missing");
  }
  if (labels_line == std::string::npos) {
    text.refuse(keys_line + 1, "the line of marker names, which begins with Frame#, is missing");
  }
  FrameTable table;
  table.separator = separator_of(text[labels_line]);
  const TrcHeader header = read_header(text, keys_line, separator_of(text[keys_line]));
  const std::size_t values_line = keys_line + 1;
  table.rate_hz = number_of(text, header, "datarate", values_line);
  table.declared_frames =
      static_cast<std::size_t>(number_of(text, header, "numframes", values_line));
  table.millimetres = millimetres_per(options.unstated.unit);
  if (const auto unit = header.find("units"); unit != header.end()) {
    const std::optional<double> mm = millimetres_per(unit->second);
    if (!mm)
      text.refuse(values_line, "the unit '" + unit->second + "' is not known", "Use mm, cm or m");
    table.millimetres = *mm;
  }
  const auto declared =
      static_cast<std::size_t>(number_of(text, header, "nummarkers", values_line));
  const std::vector<std::string> labels = read_labels(text, labels_line, table.separator, declared);
  for (std::size_t m = 0; m < labels.size(); ++m) {
    const QualifiedLabel name = split_label(labels[m]);
    PointColumns point{.marker = {.label = name.label, .subject = name.subject},
                       .xyz = {2 + 3 * m, 3 + 3 * m, 4 + 3 * m}};
    if (name.label.empty()) point.marker.label = "*" + std::to_string(m + 1);
    if (name.label.empty() || name.label.starts_with('*') ||
        lower(name.label).starts_with("unlabel")) {
      point.marker.kind = MarkerKind::unlabelled;
    }
    table.points.push_back(std::move(point));
  }
  if (declared != 0 && declared != labels.size()) {
    ctx.warn(text.file() + ": the header announces " + count_of(declared, "marker") + ", line " +
             std::to_string(labels_line + 1) + " names " + std::to_string(labels.size()));
  }
  table.frame_column = 0;
  table.time_column = 1;
  table.first_line = labels_line + 1;
  // The line of X1, Y1, Z1 … is usual but not always there.
  while (table.first_line < text.size()) {
    const std::string_view line = trim(text[table.first_line]);
    if (!line.empty() && (line[0] == '-' || (line[0] >= '0' && line[0] <= '9'))) break;
    ++table.first_line;
  }
  MarkerSequence take = read_frame_table(text, table, options, ctx);
  take.origin.unit = name_of(options.unstated.unit);
  if (const auto unit = header.find("units"); unit != header.end()) take.origin.unit = unit->second;
  return take;
}

void write_trc(const MarkerSequence& take, const std::filesystem::path& path,
               const RunContext& ctx) {
  OutputFile file(path);
  write_trc(take, file, ctx);
  file.commit();
}

void write_trc(const MarkerSequence& take, OutputFile& file, const RunContext& ctx) {
  std::vector<std::size_t> points;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind <= MarkerKind::virtual_point) points.push_back(m);
  }
  const std::string rate = format_number(take.rate_hz);
  const std::string frames = std::to_string(take.frame_count());
  file.write("PathFileType\t4\t(X/Y/Z)\t" + file.path().filename().string() + "\n");
  file.write(
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
      "OrigNumFrames\n");
  file.write(rate + "\t" + rate + "\t" + frames + "\t" + std::to_string(points.size()) + "\tmm\t" +
             rate + "\t" + std::to_string(take.first_frame) + "\t" + frames + "\n");
  std::string labels = "Frame#\tTime";
  std::string axes = "\t";
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Marker& marker = take.markers()[points[k]];
    std::string label = qualified_label(marker.subject, marker.label);
    std::ranges::replace_if(
        label, [](char c) { return c == '\t' || c == '\n' || c == '\r'; }, ' ');
    labels += "\t" + label + (k + 1 < points.size() ? "\t\t" : "");
    for (const char axis : {'X', 'Y', 'Z'})
      axes += std::string("\t") + axis + std::to_string(k + 1);
  }
  file.write(labels + "\n" + axes + "\n\n");
  std::string row;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    if (f % 1024 == 0) ctx.check_cancelled();
    row = std::to_string(take.first_frame + static_cast<int64_t>(f)) + "\t" +
          format_number(take.rate_hz > 0 ? static_cast<double>(f) / take.rate_hz : 0.0);
    for (const std::size_t m : points) {
      const bool valid = take.valid(f, m);
      for (int k = 0; k < 3; ++k) {
        row += '\t';
        if (valid) append_number(row, take.position(f, m)[k]);
      }
    }
    row += '\n';
    file.write(row);
  }
}

}  // namespace kinemesh
