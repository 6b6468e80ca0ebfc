#include "report/clean_text.h"

#include <cstddef>
#include <cstdint>

namespace kinemesh {
namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";

bool continuation(std::string_view text, std::size_t i) {
  return i < text.size() && (static_cast<uint8_t>(text[i]) & 0xC0U) == 0x80U;
}

// Length of the well-formed UTF-8 sequence at `i`, or 0 (Unicode 15, table 3-7).
std::size_t sequence_length(std::string_view text, std::size_t i) {
  const auto first = static_cast<uint8_t>(text[i]);
  if (first < 0x80) return 1;
  if (first < 0xC2 || first > 0xF4) return 0;
  const std::size_t length = first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  for (std::size_t k = 1; k < length; ++k) {
    if (!continuation(text, i + k)) return 0;
  }
  const auto second = static_cast<uint8_t>(text[i + 1]);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate = first == 0xED && second > 0x9F;
  const bool too_large = first == 0xF4 && second > 0x8F;
  return overlong || surrogate || too_large ? 0 : length;
}

std::string clean(std::string_view text, bool keep_lines) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = sequence_length(text, i);
    if (length == 0) {
      out += replacement;
      ++i;
      continue;
    }
    const char c = text[i];
    if (length > 1) {
      const bool c1_control = c == '\xC2' && static_cast<uint8_t>(text[i + 1]) < 0xA0;
      if (!c1_control) out += text.substr(i, length);
    } else if (c == '\n' && keep_lines) {
      out += c;
    } else if (c == '\t' || c == '\n' || c == '\r') {
      if (!(keep_lines && c == '\r')) out += ' ';
    } else if (static_cast<uint8_t>(c) >= 0x20 && c != 0x7F) {
      out += c;
    }
    i += length;
  }
  return out;
}

std::string escape(const std::string& text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace

std::string clean_text(std::string_view text) { return clean(text, false); }
std::string escape_markup(std::string_view text) { return escape(clean(text, false)); }
std::string escape_lines(std::string_view text) { return escape(clean(text, true)); }

std::string shorten(std::string_view text, std::size_t characters) {
  const std::string whole = clean_text(text);
  std::size_t count = 0;
  std::size_t cut = 0;  // where the last character that may stay ends
  for (std::size_t i = 0; i < whole.size(); ++count) {
    if (count + 1 == characters) cut = i;
    i += sequence_length(whole, i);
  }
  return count <= characters ? whole : whole.substr(0, cut) + "…";
}

}  // namespace kinemesh
