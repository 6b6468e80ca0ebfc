#include "capture/formats/qtm_tsv.h"

#include <algorithm>
#include <map>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

struct Header {
  std::map<std::string, std::vector<std::string>, std::less<>> values;
  std::map<std::string, std::size_t, std::less<>> lines;
  std::vector<std::vector<std::string>> events;
  std::size_t data_line = 0;
  bool column_names = false;  // a row "Frame  Time  A X  A Y …"
  std::vector<std::string> columns;
};

bool is_keyword(std::string_view word) {
  return word.size() > 1 &&
         std::ranges::all_of(word,
                             [](unsigned char c) {
                               return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
                             }) &&
         !(word[0] >= '0' && word[0] <= '9');
}

Header read_header(const TableText& text, char separator) {
  Header header;
  for (std::size_t line = 0; line < text.size(); ++line) {
    header.data_line = line;
    if (trim(text[line]).empty()) continue;
    std::vector<std::string> cells = split_cells(text[line], separator);
    if (cells[0].empty() || parse_cell(cells[0])) return header;
    const std::string first = lower(cells[0]);
    const bool names_columns =
        first == "frame" || first == "time" || (cells.size() > 2 && first.ends_with(" x"));
    if (names_columns) {
      header.column_names = true;
      header.columns = std::move(cells);
      header.data_line = line + 1;
      return header;
    }
    if (!is_keyword(cells[0])) {
      text.refuse(line, "'" + cells[0].substr(0, 40) + "' is no name that QTM writes");
    }
    const std::string key = cells[0];
    cells.erase(cells.begin());
    if (key == "EVENT") {
      header.events.push_back(std::move(cells));
    } else {
      header.lines.emplace(key, line);
      header.values.emplace(key, std::move(cells));
    }
  }
  header.data_line = text.size();
  return header;
}

std::string first_value(const Header& header, std::string_view key) {
  const auto it = header.values.find(key);
  return it == header.values.end() || it->second.empty() ? std::string() : it->second[0];
}

void refuse_other_data(const TableText& text, const Header& header) {
  const std::string data = first_value(header, "DATA_INCLUDED");
  if (header.values.contains("MARKER_NAMES") && (data.empty() || data == "3D")) return;
  const auto line = header.lines.find("DATA_INCLUDED");
  text.refuse(line == header.lines.end() ? 0 : line->second,
              data.empty() || data == "3D" ? "the line MARKER_NAMES is missing"
                                           : "this is an export of " + data + " data",
              "Export 3D data from QTM, with the header switched on");
}

/// Column of the first coordinate: behind frame and time, as far as they were exported.
std::size_t find_time_columns(const TableText& text, const Header& header, char separator,
                              std::size_t marker_count, FrameTable& table) {
  if (header.column_names) {
    std::size_t column = 0;
    if (column < header.columns.size() && lower(header.columns[column]) == "frame") {
      table.frame_column = column++;
    }
    if (column < header.columns.size() && lower(header.columns[column]).starts_with("time")) {
      table.time_column = column++;
    }
    return column;
  }
  std::vector<std::string_view> cells;
  if (header.data_line < text.size()) split_cells(text[header.data_line], separator, cells);
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  if (cells.size() == 3 * marker_count + 2) {
    table.frame_column = 0;
    table.time_column = 1;
    return 2;
  }
  return 0;
}

std::vector<Event> read_events(const TableText& text, const Header& header, double rate_hz) {
  std::vector<Event> events;
  for (const std::vector<std::string>& cells : header.events) {
    if (cells.empty()) continue;
    Event event{.label = cells[0]};
    const std::optional<double> time = cells.size() > 2 ? parse_cell(cells[2]) : std::nullopt;
    const std::optional<double> frame = cells.size() > 1 ? parse_cell(cells[1]) : std::nullopt;
    if (time) {
      event.time_s = *time;
    } else if (frame && rate_hz > 0) {
      event.time_s = (*frame - 1) / rate_hz;
    } else {
      text.refuse(0, "the event '" + event.label + "' has no time");
    }
    events.push_back(std::move(event));
  }
  return events;
}

}  // namespace

bool looks_like_qtm(std::string_view first_line) {
  const std::string_view line = trim(first_line);
  return line.starts_with("NO_OF_FRAMES") || line.starts_with("FILE_VERSION");
}

MarkerSequence read_qtm(const TableText& text, const TableReadOptions& options,
                        const RunContext& ctx) {
  if (text.size() == 0) text.refuse(0, "the file is empty");
  FrameTable table;
  table.separator = separator_of(text[0]);
  const Header header = read_header(text, table.separator);
  refuse_other_data(text, header);
  std::vector<std::string> names = header.values.at("MARKER_NAMES");
  const std::size_t names_line = header.lines.at("MARKER_NAMES");
  const std::optional<long long> declared = parse_count(first_value(header, "NO_OF_MARKERS"));
  while (!names.empty() && names.back().empty() &&
         (!declared || static_cast<long long>(names.size()) > *declared)) {
    names.pop_back();
  }
  if (declared && *declared != static_cast<long long>(names.size())) {
    text.refuse(names_line, "NO_OF_MARKERS announces " + std::to_string(*declared) +
                                " markers, MARKER_NAMES lists " + std::to_string(names.size()));
  }
  const auto types = header.values.find("TRAJECTORY_TYPES");
  table.first_line = header.data_line;
  const std::size_t first = find_time_columns(text, header, table.separator, names.size(), table);
  for (std::size_t m = 0; m < names.size(); ++m) {
    const QualifiedLabel name = split_label(names[m]);
    PointColumns point{.marker = {.label = name.label, .subject = name.subject},
                       .xyz = {first + 3 * m, first + 3 * m + 1, first + 3 * m + 2}};
    if (types != header.values.end() && m < types->second.size() &&
        lower(types->second[m]) == "virtual") {
      point.marker.kind = MarkerKind::virtual_point;
    }
    table.points.push_back(std::move(point));
  }
  // "EXT": an external time base; then the times give the rate.
  if (const auto rate = parse_cell(first_value(header, "FREQUENCY")); rate && *rate > 0) {
    table.rate_hz = *rate;
  }
  if (const auto frames = parse_count(first_value(header, "NO_OF_FRAMES"))) {
    table.declared_frames = static_cast<std::size_t>(*frames);
  }
  MarkerSequence take = read_frame_table(text, table, options, ctx);
  take.events = read_events(text, header, take.rate_hz);
  take.origin.manufacturer = "Qualisys Track Manager (TSV)";
  return take;
}

}  // namespace kinemesh
