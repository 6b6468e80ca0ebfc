// Small text helpers that several modules need.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

/// "a, b and c" with `separator` ", " and `last_separator` " and ".
std::string join(const std::vector<std::string>& words, std::string_view separator,
                 std::string_view last_separator);
std::string join(const std::vector<std::string>& words, std::string_view separator);

/// The shortest decimal text that reads back as the same double, independent of the locale.
std::string format_number(double value);
/// Appends the shortest decimal text that reads back as the same value.
void append_number(std::string& out, float value);
void append_number(std::string& out, double value);
void append_number(std::string& out, int64_t value);
inline void append_number(std::string& out, uint32_t value) {
  append_number(out, static_cast<int64_t>(value));
}
/// With a fixed number of decimals, independent of the locale.
std::string format_fixed(double value, int decimals);
/// "1 marker", "3 markers".
std::string count_of(std::size_t count, std::string_view singular, std::string_view plural = {});

std::string lower(std::string_view text);
std::string upper(std::string_view text);
std::string_view trim(std::string_view text);
/// Case-insensitive match of `*` and `?` wildcards.
bool matches_wildcard(std::string_view pattern, std::string_view text);
/// The candidate with the smallest edit distance to `word`; empty when none is close.
std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);
/// A TOML basic string.
std::string quote_toml(std::string_view text);

}  // namespace kinemesh
