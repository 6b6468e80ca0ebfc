#include "capture/formats/motive_csv.h"

#include <algorithm>
#include <map>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using Rows = std::vector<std::vector<std::string>>;

/// The names and values of the first line, which alternate.
std::map<std::string, std::string, std::less<>> general_information(
    const std::vector<std::string>& cells) {
  std::map<std::string, std::string, std::less<>> values;
  for (std::size_t i = 0; i + 1 < cells.size(); i += 2) {
    values.emplace(lower(cells[i]), cells[i + 1]);
  }
  return values;
}

bool is_type(const std::string& word) {
  static const std::vector<std::string> types = {
      "marker",      "rigid body",       "rigid body marker", "bone",
      "bone marker", "unlabeled marker", "labeled marker",    "trained markerset marker"};
  return std::ranges::find(types, lower(word)) != types.end();
}

/// Which of the rows above the columns say what.
struct HeaderRows {
  std::size_t axis_line = PointColumns::none;  // "Frame, Time (Seconds), X, Y, Z"
  std::vector<std::string> types, names, contents, axes;
};

HeaderRows find_rows(const TableText& text) {
  HeaderRows rows;
  std::vector<std::pair<std::size_t, std::vector<std::string>>> above;
  for (std::size_t line = 1; line < text.size() && line < 32; ++line) {
    std::vector<std::string> cells = split_cells(text[line], ',');
    if (cells.size() > 2 && lower(cells[0]) == "frame" && lower(cells[1]).starts_with("time")) {
      rows.axis_line = line;
      rows.axes = std::move(cells);
      break;
    }
    if (cells.size() > 2) above.emplace_back(line, std::move(cells));
  }
  if (rows.axis_line == PointColumns::none) {
    text.refuse(std::min<std::size_t>(text.size(), 7),
                "the row that begins with Frame, Time (Seconds) is missing",
                "Export from Motive with the header switched on, format version 1.2 or later");
  }
  for (std::size_t i = 0; i < above.size(); ++i) {
    if (!std::ranges::any_of(above[i].second, is_type)) continue;
    rows.types = above[i].second;
    if (i + 1 < above.size()) rows.names = above[i + 1].second;
    rows.contents = above.back().second;  // Rotation or Position, right above the axes
    break;
  }
  if (rows.names.empty()) {
    text.refuse(rows.axis_line, "the rows that give type and name of each column are missing");
  }
  return rows;
}

Marker marker_of(const std::string& name, const std::string& type) {
  const QualifiedLabel label = split_label(name);
  Marker marker{.label = label.label, .subject = label.subject};
  const std::string kind = lower(type);
  if (lower(label.label).starts_with("unlabel") || kind == "unlabeled marker") {
    marker.kind = MarkerKind::unlabelled;
  } else if (kind != "marker" && kind != "labeled marker") {
    marker.kind = MarkerKind::virtual_point;
    marker.description = kind + (kind.ends_with("marker") ? ", solved position" : ", pivot");
  }
  return marker;
}

std::vector<PointColumns> find_points(const HeaderRows& rows) {
  const auto cell = [](const std::vector<std::string>& row, std::size_t i) {
    return i < row.size() ? row[i] : std::string();
  };
  std::vector<PointColumns> points;
  for (std::size_t c = 2; c + 2 < rows.axes.size(); ++c) {
    const bool is_position = lower(cell(rows.contents, c)) == "position" &&
                             lower(rows.axes[c]) == "x" && lower(rows.axes[c + 1]) == "y" &&
                             lower(rows.axes[c + 2]) == "z";
    if (!is_position || !is_type(cell(rows.types, c))) continue;
    points.push_back(
        {.marker = marker_of(cell(rows.names, c), cell(rows.types, c)), .xyz = {c, c + 1, c + 2}});
    c += 2;
  }
  std::stable_partition(points.begin(), points.end(), [](const PointColumns& p) {
    return p.marker.kind != MarkerKind::virtual_point;
  });
  return points;
}

}  // namespace

bool looks_like_motive_csv(std::string_view first_line) {
  return lower(first_line.substr(0, 64)).find("format version") < 4;
}

MarkerSequence read_motive_csv(const TableText& text, const TableReadOptions& options,
                               const RunContext& ctx) {
  if (text.size() == 0) text.refuse(0, "the file is empty");
  const auto general = general_information(split_cells(text[0], ','));
  const auto value = [&general](std::string_view key) {
    const auto it = general.find(key);
    return it == general.end() ? std::string() : it->second;
  };
  const HeaderRows rows = find_rows(text);
  FrameTable table;
  table.first_line = rows.axis_line + 1;
  table.points = find_points(rows);
  if (table.points.empty()) {
    text.refuse(rows.axis_line, "no column holds marker positions",
                "Export from Motive with Markers switched on");
  }
  table.frame_column = 0;
  table.time_column = 1;
  table.frame_number_offset = 1;
  for (const std::string_view key : {"export frame rate", "capture frame rate"}) {
    const std::optional<double> rate = parse_cell(value(key));
    if (rate && *rate > 0 && table.rate_hz == 0) table.rate_hz = *rate;
  }
  const std::string unit = value("length units");
  if (const std::optional<double> mm = millimetres_per(unit)) {
    table.millimetres = *mm;
  } else if (!unit.empty()) {
    text.refuse(0, "the length unit '" + unit + "' is not known");
  } else {
    table.millimetres = 1000.0;
    ctx.warn(text.file() + ": the length unit is not given; metres are assumed");
  }
  if (const auto count = parse_count(value("total exported frames"))) {
    table.declared_frames = static_cast<std::size_t>(*count);
  }
  MarkerSequence take = read_frame_table(text, table, options, ctx);
  take.origin.unit = unit.empty() ? "m" : lower(unit);
  take.origin.manufacturer =
      "OptiTrack Motive (CSV format version " + value("format version") + ")";
  take.origin.x_screen = "-X";  // Motive: right-handed, y up, x to the left of one who faces z
  take.origin.y_screen = "+Y";
  return take;
}

}  // namespace kinemesh
