#include "config/json_text.h"

#include <algorithm>

#include "config/error.h"

namespace kinemesh {

std::size_t json_nesting(std::string_view text) {
  std::size_t depth = 0, deepest = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    switch (text[i]) {
      case '"': quoted = !quoted; break;
      case '\\': i += quoted ? 1 : 0; break;
      case '[':
      case '{': deepest = std::max(deepest, depth += quoted ? 0 : 1); break;
      case ']':
      case '}': depth -= quoted || depth == 0 ? 0 : 1; break;
      default: break;
    }
  }
  return deepest;
}

void refuse_deep_json(std::string_view text, const std::string& file) {
  constexpr std::size_t deepest = 500;
  if (const std::size_t depth = json_nesting(text); depth > deepest) {
    throw InputError({.what = "the JSON is malformed: its brackets are nested " +
                              std::to_string(depth) + " deep",
                      .file = file});
  }
}

}  // namespace kinemesh
