// Text from files made fit to be shown: labels of real recordings hold any bytes.
#pragma once

#include <string>
#include <string_view>

namespace kinemesh {

/// Valid UTF-8 without control characters: ill-formed sequences become U+FFFD, tabs and line ends
/// become spaces, other control characters disappear.
std::string clean_text(std::string_view text);
/// clean_text with & < > " ' as entities: safe in XML and HTML text and in quoted attributes.
std::string escape_markup(std::string_view text);
/// escape_markup that keeps line ends, for preformatted blocks.
std::string escape_lines(std::string_view text);
/// At most `characters` code points, the last one an ellipsis when something was cut off.
std::string shorten(std::string_view text, std::size_t characters);

}  // namespace kinemesh
