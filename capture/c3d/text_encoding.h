// Text of C3D files: UTF-8 where it is valid, Windows-1252 otherwise.
#pragma once

#include <string>
#include <string_view>

namespace kinemesh {

bool is_utf8(std::string_view text);
std::string utf8_from_windows_1252(std::string_view text);

}  // namespace kinemesh
