// What every reader of JSON checks before it parses.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kinemesh {

/// How deep brackets and braces are nested, strings left aside.
std::size_t json_nesting(std::string_view text);

/// Throws InputError when the text is nested deeper than any file that we know: values are copied
/// by recursion, and a file of a million brackets would exhaust the stack.
void refuse_deep_json(std::string_view text, const std::string& file);

}  // namespace kinemesh
