#include "mesh/formats/text_scanner.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "config/error.h"

namespace kinemesh {

void TextScanner::next_line() {
  const void* found = at_ == end_ ? nullptr : std::memchr(at_, '\n', end_ - at_);
  at_ = found == nullptr ? end_ : static_cast<const char*>(found) + 1;
}

std::string_view TextScanner::rest_of_line() {
  skip_blanks();
  const void* found = at_ == end_ ? nullptr : std::memchr(at_, '\n', end_ - at_);
  const char* stop = found == nullptr ? end_ : static_cast<const char*>(found);
  const char* last = stop;
  while (last != at_ && is_separator(last[-1])) --last;
  const std::string_view rest(at_, last - at_);
  at_ = stop;
  return rest;
}

std::string_view TextScanner::word() {
  skip_blanks();
  const char* const from = at_;
  while (at_ != end_ && !is_separator(*at_)) ++at_;
  return {from, static_cast<std::size_t>(at_ - from)};
}

void TextScanner::skip_space(char comment) {
  while (at_ != end_) {
    if (is_separator(*at_)) {
      ++at_;
    } else if (comment != 0 && *at_ == comment) {
      next_line();
    } else {
      return;
    }
  }
}

double TextScanner::real(const char* what) {
  skip_blanks();
  const char* from = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
  double value = 0.0;
  const auto [next, error] = std::from_chars(from, end_, value);
  if (error != std::errc()) refuse_word(what);
  at_ = next;
  require_separator(what);
  return value;
}

/// Numbers outside the range of float: too small ones are 0; too large ones infinite, which the
/// caller's check for finite positions refuses.
float TextScanner::unusual_number(const char* what) {
  const char* from = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
  double value = 0.0;
  const auto [next, error] = std::from_chars(from, end_, value);
  if (error == std::errc::invalid_argument) refuse_word(what);
  at_ = next;
  if (error == std::errc::result_out_of_range) return 0.0F * static_cast<float>(value);
  return static_cast<float>(value);
}

void TextScanner::refuse_coordinate() const {
  fail("a coordinate is not a finite number", "Fill the gap, or leave the vertex out");
}

void TextScanner::refuse_word(const char* what) {
  const char* stop = at_;
  while (stop != end_ && !is_separator(*stop) && stop - at_ < 40) ++stop;
  std::string given;
  for (const char* c = at_; c != stop; ++c) {
    given += *c >= 32 && *c < 127 ? *c : '?';
  }
  fail(given.empty() ? std::string(what) + " is missing"
                     : "'" + given + "' stands where " + what + " should be");
}

std::size_t TextScanner::line() const {
  return 1 + static_cast<std::size_t>(std::count(begin_, at_, '\n'));
}

void TextScanner::fail(const std::string& what, const std::string& remedy) const {
  throw InputError(
      {.what = what, .file = name_, .place = "line " + std::to_string(line()), .remedy = remedy});
}

}  // namespace kinemesh
