// Command lines as texts that a shell reads back.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

/// The word, in single quotes where a shell would take it apart or change it.
std::string shell_quote(const std::string& word);
/// The words of a line that was put together by shell_quote().
std::vector<std::string> shell_words(std::string_view line);

}  // namespace kinemesh
