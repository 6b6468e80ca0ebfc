// Style sheet and scripts of the HTML pages, compiled in by cmake/EmbedText.cmake.
#pragma once

#include <string_view>

namespace kinemesh {

/// The content of report/html/NAME. Throws InternalError when it was not embedded.
std::string_view embedded_text(std::string_view name);

}  // namespace kinemesh
