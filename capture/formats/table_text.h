// Text tables as motion-capture programs export them: lines, cells and numbers, with the errors
// that name file and line.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

/// A text file in memory, split into lines. Accepts \n, \r\n and \r line ends and a UTF-8 mark.
class TableText {
 public:
  /// Throws InputError for UTF-16 and for binary content. `file` is named in all errors.
  TableText(std::string content, std::string file);
  TableText(const TableText&) = delete;
  TableText& operator=(const TableText&) = delete;

  std::size_t size() const { return lines_.size(); }
  std::string_view operator[](std::size_t line) const { return lines_[line]; }
  /// True when the last line has no line end: the file may be cut off there.
  bool unfinished() const { return unfinished_; }
  const std::string& file() const { return file_; }
  /// Throws InputError at this line (0-based; shown 1-based).
  [[noreturn]] void refuse(std::size_t line, const std::string& what,
                           const std::string& remedy = "") const;

 private:
  std::string content_, file_;
  std::vector<std::string_view> lines_;
  bool unfinished_ = false;
};

/// Cells of a line; quotes around a cell are taken off and "" inside becomes ". Cells are trimmed.
std::vector<std::string> split_cells(std::string_view line, char separator);
/// The same without copies for lines of numbers, where quotes play no role.
void split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells);
/// A cell for a table: quoted when it holds the separator, a quote or a line end.
std::string quote_cell(std::string_view text, char separator);

/// The number in a trimmed cell. A decimal comma is accepted when the cell holds no point. Empty
/// optional for anything else; "nan" gives NaN.
std::optional<double> parse_cell(std::string_view cell);
/// True for an empty cell and for "nan", "null", "n/a" and "-" in any case: no value.
bool is_blank_cell(std::string_view cell);
/// A positive integer of at most 15 digits ("12", "12.0").
std::optional<long long> parse_count(std::string_view cell);

/// Millimetres in one unit: "mm", "cm", "m", "in", "ft" and their full names in any case and
/// number ("Meters", "millimetre"). Empty optional for an unknown word.
std::optional<double> millimetres_per(std::string_view unit);

/// "Subject:Label" split at the first colon; without one (or with nothing before or behind it) the
/// subject is empty.
struct QualifiedLabel {
  std::string subject, label;
};
QualifiedLabel split_label(std::string_view text);
/// "subject:label", or the label alone without a subject.
std::string qualified_label(std::string_view subject, std::string_view label);

/// What separates the cells of a line: tab, semicolon or comma, the first of them that it holds;
/// tab when none.
char separator_of(std::string_view line);

}  // namespace kinemesh
