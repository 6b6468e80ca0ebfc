#include "capture/formats/table_text.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {

TableText::TableText(std::string content, std::string file)
    : content_(std::move(content)), file_(std::move(file)) {
  std::string_view text = content_;
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw InputError({.what = "the text is stored as UTF-16",
                      .file = file_,
                      .remedy = "Save it as plain text in UTF-8"});
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    throw InputError({.what = "this is no text file: it holds zero bytes",
                      .file = file_,
                      .place = "byte " + std::to_string(zero)});
  }
  unfinished_ = !text.empty() && text.back() != '\n' && text.back() != '\r';
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    lines_.push_back(text.substr(0, end));
    std::size_t next = end;
    if (next < text.size()) next += text.substr(next).starts_with("\r\n") ? 2 : 1;
    text.remove_prefix(next);
  }
}

void TableText::refuse(std::size_t line, const std::string& what, const std::string& remedy) const {
  throw InputError(
      {.what = what, .file = file_, .place = "line " + std::to_string(line + 1), .remedy = remedy});
}

std::vector<std::string> split_cells(std::string_view line, char separator) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  bool was_quoted = false;
  const auto finish = [&cells, &was_quoted] {
    if (!was_quoted) cells.back() = std::string(trim(cells.back()));
    was_quoted = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += c;
      ++i;
    } else if (c == '"' && (quoted || trim(cells.back()).empty())) {
      if (!quoted) cells.back().clear();
      quoted = !quoted;
      was_quoted = true;
    } else if (c == separator && !quoted) {
      finish();
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  finish();
  return cells;
}

void split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  while (true) {
    const std::size_t end = line.find(separator);
    cells.push_back(trim(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

std::string quote_cell(std::string_view text, char separator) {
  const bool plain = text.find(separator) == std::string_view::npos &&
                     text.find_first_of("\"\r\n") == std::string_view::npos && trim(text) == text;
  if (plain) return std::string(text);
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c == '\r' || c == '\n' ? ' ' : c;  // a cell stays on its line
  }
  return out + "\"";
}

std::optional<double> parse_cell(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0.0;
  const auto whole = [&value](std::string_view text) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
  };
  if (whole(cell)) return value;
  const std::size_t comma = cell.find(',');
  if (comma == std::string_view::npos || cell.size() > 64 || cell.find('.') != cell.npos) return {};
  std::string with_point(cell);
  with_point[comma] = '.';
  if (whole(with_point)) return value;
  return {};
}

bool is_blank_cell(std::string_view cell) {
  if (cell.empty() || cell == "-") return true;
  if (cell.size() > 4) return false;
  const std::string word = lower(cell);
  return word == "nan" || word == "-nan" || word == "null" || word == "n/a" || word == "na";
}

std::optional<long long> parse_count(std::string_view cell) {
  const std::optional<double> value = parse_cell(cell);
  if (!value || !(*value >= 0) || *value > 1e15) return {};
  const auto count = static_cast<long long>(*value);
  if (static_cast<double>(count) != *value) return {};
  return count;
}

std::optional<double> millimetres_per(std::string_view unit) {
  static const std::map<std::string, double, std::less<>> units = {
      {"mm", 1.0},          {"millimeter", 1.0},  {"millimetre", 1.0}, {"cm", 10.0},
      {"centimeter", 10.0}, {"centimetre", 10.0}, {"m", 1000.0},       {"meter", 1000.0},
      {"metre", 1000.0},    {"dm", 100.0},        {"in", 25.4},        {"inch", 25.4},
      {"inche", 25.4},      {"ft", 304.8},        {"foot", 304.8},     {"feet", 304.8}};
  std::string word = lower(trim(unit));
  if (const auto it = units.find(word); it != units.end()) return it->second;
  if (word.size() > 3 && word.ends_with('s')) word.pop_back();
  if (const auto it = units.find(word); it != units.end()) return it->second;
  return {};
}

QualifiedLabel split_label(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0 || colon + 1 == text.size()) {
    return {.subject = {}, .label = std::string(text)};
  }
  return {.subject = std::string(trim(text.substr(0, colon))),
          .label = std::string(trim(text.substr(colon + 1)))};
}

std::string qualified_label(std::string_view subject, std::string_view label) {
  std::string text(subject);
  if (!text.empty()) text += ':';
  return text.append(label);
}

char separator_of(std::string_view line) {
  for (const char c : {'\t', ';', ','}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return '\t';
}

}  // namespace kinemesh
