// Fast reading of numbers and words from text held in memory, by lines. Lines end with LF or CRLF.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace kinemesh {

class TextScanner {
 public:
  /// `text` must outlive the scanner. `name` is the file's, for errors.
  TextScanner(std::string_view text, std::string name)
      : begin_(text.data()), at_(begin_), end_(begin_ + text.size()), name_(std::move(name)) {}

  bool at_end() const { return at_ == end_; }
  std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
  void move_to(std::size_t offset) { at_ = begin_ + offset; }
  /// Skips spaces and tabs (and CR); true when the line has nothing more.
  bool at_line_end() {
    skip_blanks();
    return at_ == end_ || *at_ == '\n';
  }
  /// Moves behind the next LF.
  void next_line();
  /// What is left of this line, without blanks around it; stays before the LF.
  std::string_view rest_of_line();
  /// The next run of characters other than blanks and line ends; empty at a line's end.
  std::string_view word();
  /// Skips blanks and line ends, and comments that begin with `comment` (0: none).
  void skip_space(char comment = 0);
  /// The character at the cursor, or 0 at the end.
  char peek() const { return at_ == end_ ? '\0' : *at_; }
  void skip(std::size_t count) { at_ += count; }

  /// The number at the cursor, after blanks but on this line. Throws InputError naming the line;
  /// `what` says which number ("coordinate").
  float number(const char* what) {
    skip_blanks();
    float value = 0.0F;
    const char* from = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
    const auto [next, error] = std::from_chars(from, end_, value);
    if (error == std::errc()) {
      at_ = next;
    } else {
      value = unusual_number(what);
    }
    require_separator(what);
    return value;
  }
  /// One that is finite.
  float coordinate() {
    const float value = number("a coordinate");
    if (!std::isfinite(value)) refuse_coordinate();
    return value;
  }
  double real(const char* what);
  int64_t integer(const char* what) {
    skip_blanks();
    int64_t value = 0;
    const char* from = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
    const auto [next, error] = std::from_chars(from, end_, value);
    if (error != std::errc()) refuse_word(what);
    at_ = next;
    return value;
  }

  /// 1-based number of the cursor's line.
  std::size_t line() const;
  [[noreturn]] void fail(const std::string& what, const std::string& remedy = {}) const;

 private:
  void skip_blanks() {
    while (at_ != end_ && (*at_ == ' ' || *at_ == '\t' || *at_ == '\r')) ++at_;
  }
  static bool is_separator(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  void require_separator(const char* what) {
    if (at_ != end_ && !is_separator(*at_)) refuse_word(what);
  }
  float unusual_number(const char* what);
  [[noreturn]] void refuse_word(const char* what);
  [[noreturn]] void refuse_coordinate() const;

  const char* begin_;
  const char* at_;
  const char* end_;
  std::string name_;
};

}  // namespace kinemesh
