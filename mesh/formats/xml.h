// Just enough XML for VTK's files: elements, attributes, text, comments. No document types and no
// entities but the five of XML, so nothing expands and nothing is fetched.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kinemesh {

struct XmlElement {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string_view text;       ///< the longest run of text directly inside, entities as they stand
  std::size_t text_begin = 0;  ///< byte of the file at which the element's content begins
  std::vector<XmlElement> children;

  /// Null when it has none of that name.
  const std::string* attribute(std::string_view key) const;
  /// The first child of that name, or null.
  const XmlElement* child(std::string_view key) const;
};

/// The root element; `text` must outlive it. Parsing ends inside the first element named `stop_at`
/// (VTK's raw data are no XML), whose text runs to the end of the file. Throws InputError naming
/// the line.
XmlElement parse_xml(std::string_view text, const std::string& name, std::string_view stop_at = {});

/// `text` with & < > " ' as entities.
std::string escape_xml(std::string_view text);

}  // namespace kinemesh
