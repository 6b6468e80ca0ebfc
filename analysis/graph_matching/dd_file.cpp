#include "analysis/graph_matching/dd_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t max_file_bytes = std::size_t{4} << 30;

std::string quoted(std::string_view word) {
  std::string text;
  for (const char c : word.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
  return "'" + text + (word.size() > 40 ? "…'" : "'");
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

class Parser {
 public:
  Parser(std::string_view text, const std::string& file) : text_(text), file_(file) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);  // mark of UTF-8
  }

  MatchingProblem parse() {
    while (next_line()) parse_line();
    if (!has_header_) fail("the file has no line 'p LEFT RIGHT ASSIGNMENTS PAIRS'");
    if (problem_.assignments.size() != assignments_promised_) {
      fail("the file ends after " + std::to_string(problem_.assignments.size()) + " of " +
           std::to_string(assignments_promised_) + " assignments");
    }
    if (problem_.pairs.size() != pairs_promised_) {
      fail("the file ends after " + std::to_string(problem_.pairs.size()) + " of " +
           std::to_string(pairs_promised_) + " pairs");
    }
    order_assignments();
    return std::move(problem_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, std::size_t line = 0) const {
    throw InputError({.what = what,
                      .file = file_,
                      .place = "line " + std::to_string(std::max<std::size_t>(
                                             1, line > 0 ? line : line_number_)),
                      .remedy = "docs/matching.md describes the format"});
  }

  /// The next line's words in words_; more than the longest kind of line has are counted only.
  bool next_line() {
    if (position_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', position_), text_.size());
    const std::string_view line = text_.substr(position_, end - position_);
    position_ = end + 1;
    ++line_number_;
    word_count_ = 0;
    std::size_t at = 0;
    while (true) {
      while (at < line.size() && is_space(line[at])) ++at;
      if (at == line.size()) return true;
      const std::size_t begin = at;
      while (at < line.size() && !is_space(line[at])) ++at;
      if (word_count_ < words_.size()) words_[word_count_] = line.substr(begin, at - begin);
      ++word_count_;
      if (words_[0] == "c") return true;  // a comment may be long
    }
  }

  void parse_line() {
    if (word_count_ == 0) return;
    const std::string_view kind = words_[0];
    if (kind == "c" || kind == "i0" || kind == "i1" || kind == "n0" || kind == "n1") return;
    if (kind == "p") return parse_header();
    if (kind != "a" && kind != "e") {
      fail("a line begins with " + quoted(kind) + " instead of c, p, a, e, i0, i1, n0 or n1");
    }
    if (!has_header_) fail("an '" + std::string(kind) + "' line stands before the 'p' line");
    kind == "a" ? parse_assignment() : parse_pair();
  }

  void expect_words(std::size_t count, const char* form) const {
    if (word_count_ != count) fail(std::string("expected '") + form + "'");
  }

  uint32_t index(std::size_t word, uint64_t limit, const char* of_what) const {
    const std::string_view w = words_[word];
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    if (error != std::errc() || end != w.data() + w.size()) {
      fail(quoted(w) + " is no " + of_what);
    }
    if (value >= limit) {
      fail("the " + std::string(of_what) + " " + std::to_string(value) + " is not below " +
           std::to_string(limit));
    }
    return static_cast<uint32_t>(value);
  }

  double cost(std::size_t word) {
    std::string_view w = words_[word];
    if (w.size() > 1 && w[0] == '+' && w[1] != '-') w.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    // Out of range, with the value left alone: nearer to 0 than a number can be, or too large.
    const bool tiny = error == std::errc::result_out_of_range &&
                      std::abs(std::strtod(std::string(w).c_str(), nullptr)) < 1.0;
    if ((error != std::errc() && !tiny) || end != w.data() + w.size()) {
      fail(quoted(w) + " is no cost");
    }
    if (!std::isfinite(value)) fail("the cost " + quoted(w) + " is not a finite number");
    sum_ += std::abs(value);
    if (!std::isfinite(sum_)) {
      fail("the costs up to here add up to more than a number can hold (1.8e308)");
    }
    return value;
  }

  void parse_header() {
    if (has_header_) fail("a second 'p' line");
    expect_words(5, "p LEFT RIGHT ASSIGNMENTS PAIRS");
    problem_.left_count = index(1, uint64_t{max_matching_nodes} + 1, "number of left nodes");
    problem_.right_count = index(2, uint64_t{max_matching_nodes} + 1, "number of right nodes");
    assignments_promised_ = index(3, unmatched, "number of assignments");
    pairs_promised_ = index(4, unmatched, "number of pairs");
    // Both can take no more than there is text for: "a 0 0 0 0" and "e 0 1 0" with their newlines.
    problem_.assignments.reserve(std::min<std::size_t>(assignments_promised_, text_.size() / 10));
    problem_.pairs.reserve(std::min<std::size_t>(pairs_promised_, text_.size() / 8));
    has_header_ = true;
  }

  void parse_assignment() {
    expect_words(5, "a INDEX LEFT_NODE RIGHT_NODE COST");
    order_.push_back({index(1, assignments_promised_, "assignment"), line_number_});
    problem_.assignments.push_back({.left = index(2, problem_.left_count, "left node"),
                                    .right = index(3, problem_.right_count, "right node"),
                                    .cost = cost(4)});
    if (problem_.assignments.size() > assignments_promised_) {
      fail("more assignments than the 'p' line promises");
    }
  }

  void parse_pair() {
    expect_words(4, "e INDEX INDEX COST");
    const MatchingPair pair{.a = index(1, assignments_promised_, "assignment"),
                            .b = index(2, assignments_promised_, "assignment"),
                            .cost = cost(3)};
    if (pair.a == pair.b) fail("the pair joins an assignment with itself");
    problem_.pairs.push_back(pair);
    if (problem_.pairs.size() > pairs_promised_) fail("more pairs than the 'p' line promises");
  }

  /// Puts the assignments at their indices; they may stand in any order.
  void order_assignments() {
    std::vector<MatchingAssignment> ordered(problem_.assignments.size());
    std::vector<std::size_t> line_of(ordered.size(), 0);
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const auto [at, line] = order_[k];
      if (line_of[at] != 0) {
        fail("assignment " + std::to_string(at) + " stands in line " + std::to_string(line_of[at]) +
                 " already",
             line);
      }
      line_of[at] = line;
      ordered[at] = problem_.assignments[k];
    }
    problem_.assignments = std::move(ordered);
    refuse_duplicates(line_of);
  }

  void refuse_duplicates(const std::vector<std::size_t>& line_of) const {
    const auto key = [this](std::size_t a) {
      const MatchingAssignment& it = problem_.assignments[a];
      return std::tuple(it.left, it.right);
    };
    std::vector<std::size_t> sorted(line_of.size());
    for (std::size_t a = 0; a < sorted.size(); ++a) sorted[a] = a;
    std::ranges::sort(sorted, [&](std::size_t a, std::size_t b) {
      return std::tuple(key(a), line_of[a]) < std::tuple(key(b), line_of[b]);
    });
    for (std::size_t k = 1; k < sorted.size(); ++k) {
      if (key(sorted[k]) != key(sorted[k - 1])) continue;
      fail("the same nodes are assigned in line " + std::to_string(line_of[sorted[k - 1]]) +
               " already",
           line_of[sorted[k]]);
    }
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t position_ = 0, line_number_ = 0, word_count_ = 0;
  std::array<std::string_view, 6> words_;
  double sum_ = 0.0;  // of the costs' magnitudes
  bool has_header_ = false;
  std::size_t assignments_promised_ = 0, pairs_promised_ = 0;
  std::vector<std::pair<uint32_t, std::size_t>> order_;  // index and line of each assignment read
  MatchingProblem problem_;
};

}  // namespace

MatchingProblem parse_dd(std::string_view text, const std::string& file_name) {
  return Parser(text, file_name).parse();
}

MatchingProblem read_dd(const std::filesystem::path& path) {
  return parse_dd(read_file(path, max_file_bytes), path.string());
}

std::string format_dd(const MatchingProblem& problem) {
  std::string text = "p " + std::to_string(problem.left_count) + " " +
                     std::to_string(problem.right_count) + " " +
                     std::to_string(problem.assignments.size()) + " " +
                     std::to_string(problem.pairs.size()) + "\n";
  for (std::size_t a = 0; a < problem.assignments.size(); ++a) {
    const MatchingAssignment& it = problem.assignments[a];
    text += "a " + std::to_string(a) + " " + std::to_string(it.left) + " " +
            std::to_string(it.right) + " ";
    append_number(text, it.cost);
    text += '\n';
  }
  for (const MatchingPair& it : problem.pairs) {
    text += "e " + std::to_string(it.a) + " " + std::to_string(it.b) + " ";
    append_number(text, it.cost);
    text += '\n';
  }
  return text;
}

}  // namespace kinemesh
