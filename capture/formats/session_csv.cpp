#include "capture/formats/session_csv.h"

#include <algorithm>
#include <map>

#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::string_view mark = "# kinemesh points csv 1";

std::string name_in_table(const Marker& marker) {
  return qualified_label(marker.subject, marker.label);
}

/// What a reader makes of a column name alone.
Marker marker_from_name(const std::string& name) {
  const QualifiedLabel split = split_label(name);
  Marker marker{.label = split.label, .subject = split.subject};
  if (split.label.starts_with('*')) marker.kind = MarkerKind::unlabelled;
  return marker;
}

std::optional<MarkerKind> kind_from_name(std::string_view word) {
  for (const MarkerKind kind :
       {MarkerKind::marker, MarkerKind::unlabelled, MarkerKind::virtual_point, MarkerKind::angle,
        MarkerKind::force, MarkerKind::moment, MarkerKind::power, MarkerKind::scalar}) {
    if (name_of(kind) == word) return kind;
  }
  return {};
}

class Writer {
 public:
  Writer(const MarkerSequence& take, OutputFile& file)
      : take_(take), file_(file), uncertain_(!take.uncertainty().empty()) {}

  void write(const RunContext& ctx) {
    write_comments();
    write_names();
    for (std::size_t f = 0; f < take_.frame_count(); ++f) {
      if (f % 1024 == 0) ctx.check_cancelled();
      write_frame(f);
    }
  }

 private:
  void write_comments() {
    file_.write(std::string(mark) + "\n");
    if (take_.rate_hz > 0) file_.write("# rate_hz," + format_number(take_.rate_hz) + "\n");
    for (const Event& e : take_.events) {
      file_.write("# event," + quote_cell(e.label, ',') + "," + quote_cell(e.context, ',') + "," +
                  quote_cell(e.subject, ',') + "," + format_number(e.time_s) + "\n");
    }
    for (const Marker& m : take_.markers()) {
      Marker plain = marker_from_name(name_in_table(m));
      plain.description = m.description;
      if (plain == m) continue;
      file_.write("# marker," + quote_cell(name_in_table(m), ',') + "," +
                  quote_cell(m.subject, ',') + "," + quote_cell(m.label, ',') + "," +
                  std::string(name_of(m.kind)) + "," + quote_cell(m.unit, ',') + "\n");
    }
  }

  void write_names() {
    row_ = "frame,time_s";
    for (const Marker& m : take_.markers()) {
      for (const char* part : {".x", ".y", ".z", ".valid", ".residual"}) {
        row_ += "," + quote_cell(name_in_table(m) + part, ',');
      }
      if (uncertain_) row_ += "," + quote_cell(name_in_table(m) + ".uncertainty", ',');
    }
    file_.write(row_ + "\n");
  }

  void write_frame(std::size_t f) {
    const int64_t frame = take_.first_frame + static_cast<int64_t>(f);
    row_ = std::to_string(frame) + "," +
           format_number(take_.rate_hz > 0 ? static_cast<double>(frame - 1) / take_.rate_hz : 0.0);
    for (std::size_t m = 0; m < take_.marker_count(); ++m) {
      if (!take_.valid(f, m)) {
        row_ += uncertain_ ? ",,,,0,," : ",,,,0,";
        continue;
      }
      for (int k = 0; k < 3; ++k) add(take_.position(f, m)[k]);
      row_ += take_.filled(f, m) ? ",2" : ",1";
      const std::size_t sample = take_.sample(f, m);
      add(take_.residuals()[sample]);
      if (uncertain_ && take_.filled(f, m)) {
        add(take_.uncertainty()[sample]);
      } else if (uncertain_) {
        row_ += ',';
      }
    }
    file_.write(row_ += '\n');
  }

  void add(float value) { append_number(row_ += ',', value); }

  const MarkerSequence& take_;
  OutputFile& file_;
  bool uncertain_;
  std::string row_;
};

struct Comments {
  double rate_hz = 0.0;
  std::vector<Event> events;
  std::map<std::string, std::vector<Marker>> markers;  // several may share a name
  std::size_t header_line = 0;
};

/// Names may hold tabs and semicolons: what makes a cell of its own of a column that is always
/// there separates.
char comment_separator(std::string_view header) {
  for (const char c : {',', '\t', ';'}) {
    const std::vector<std::string> names = split_cells(header, c);
    if (std::ranges::count(names, "frame") + std::ranges::count(names, "time_s") > 0) return c;
  }
  for (const char c : {'\t', ';'}) {
    if (header.find(c) != std::string_view::npos) return c;
  }
  return ',';
}

/// Reads one "# key,values" line.
void read_comment(const TableText& text, std::size_t line, char separator, Comments& comments) {
  std::string_view content = trim(text[line]);
  if (content.starts_with('"')) content.remove_prefix(1);  // spreadsheets quote what has commas
  content.remove_prefix(std::min(content.size(), std::size_t{1}));
  const bool own_comma = split_cells(content, separator).size() < 2;
  const std::vector<std::string> cells = split_cells(content, own_comma ? ',' : separator);
  if (cells[0] == "rate_hz" && cells.size() > 1) {
    const std::optional<double> rate = parse_cell(cells[1]);
    if (!rate || !(*rate >= 0)) text.refuse(line, "'" + cells[1] + "' is no frame rate");
    comments.rate_hz = *rate;
  } else if (cells[0] == "event") {
    const std::optional<double> time = cells.size() > 4 ? parse_cell(cells[4]) : std::nullopt;
    if (!time) text.refuse(line, "the event has no time");
    comments.events.push_back({cells[1], cells[2], cells[3], *time});
  } else if (cells[0] == "marker") {
    const auto kind = cells.size() > 5 ? kind_from_name(cells[4]) : std::nullopt;
    if (!kind) text.refuse(line, "the marker's kind is missing or not known");
    comments.markers[cells[1]].push_back(
        {.label = cells[3], .subject = cells[2], .kind = *kind, .unit = cells[5]});
  }
}

Comments read_comments(const TableText& text, char& separator) {
  Comments comments;
  while (comments.header_line < text.size()) {
    const std::string_view line = trim(text[comments.header_line]);
    if (!line.empty() && !line.starts_with('#') && !line.starts_with("\"#")) break;
    ++comments.header_line;
  }
  if (comments.header_line == text.size())
    text.refuse(text.size(), "the row of column names is missing");
  separator = comment_separator(text[comments.header_line]);
  for (std::size_t line = 0; line < comments.header_line; ++line) {
    if (!trim(text[line]).empty()) read_comment(text, line, separator, comments);
  }
  return comments;
}

std::string without_suffix(const std::string& text, std::string_view suffix) {
  return text.ends_with(suffix) && text.size() > suffix.size()
             ? text.substr(0, text.size() - suffix.size())
             : std::string();
}

std::vector<PointColumns> find_points(const TableText& text, Comments& comments,
                                      const std::vector<std::string>& names) {
  std::vector<PointColumns> points;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const std::string name = without_suffix(names[c], ".x");
    if (name.empty()) continue;
    if (c + 2 >= names.size() || names[c + 1] != name + ".y" || names[c + 2] != name + ".z") {
      std::string what = "behind '";
      what.append(names[c]).append("' the columns '").append(name).append(".y' and '");
      text.refuse(comments.header_line, what.append(name).append(".z' must follow"));
    }
    PointColumns point{.marker = marker_from_name(name), .xyz = {c, c + 1, c + 2}};
    if (const auto it = comments.markers.find(name);
        it != comments.markers.end() && !it->second.empty()) {
      point.marker = it->second.front();
      it->second.erase(it->second.begin());
    }
    for (c += 3; c < names.size(); ++c) {
      if (names[c] == name + ".valid") {
        point.valid = c;
      } else if (names[c] == name + ".residual") {
        point.residual = c;
      } else if (names[c] == name + ".uncertainty") {
        point.uncertainty = c;
      } else {
        break;
      }
    }
    --c;
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace

bool looks_like_session_csv(std::string_view first_line) {
  std::string_view line = trim(first_line);
  if (line.starts_with('"')) line.remove_prefix(1);
  if (line.starts_with(mark.substr(0, mark.size() - 1))) return true;
  return line.starts_with("frame") && line.find("time_s") == 6;
}

MarkerSequence read_session_csv(const TableText& text, const TableReadOptions& options,
                                const RunContext& ctx) {
  FrameTable table;
  Comments comments = read_comments(text, table.separator);
  const std::vector<std::string> names = split_cells(text[comments.header_line], table.separator);
  table.first_line = comments.header_line + 1;
  table.rate_hz = comments.rate_hz;
  for (std::size_t c = 0; c < names.size(); ++c) {
    if (names[c] == "frame") table.frame_column = c;
    if (names[c] == "time_s") table.time_column = c;
  }
  table.points = find_points(text, comments, names);
  MarkerSequence take = read_frame_table(text, table, options, ctx);
  take.events = std::move(comments.events);
  return take;
}

void write_session_csv(const MarkerSequence& take, OutputFile& file, const RunContext& ctx) {
  Writer(take, file).write(ctx);
}

}  // namespace kinemesh
