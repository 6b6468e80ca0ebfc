// The parts of HTML reports: plain structs that render themselves to safe markup.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "report/canvas.h"
#include "report/html/page.h"

namespace kinemesh {

struct Paragraph {
  std::string text;
  bool muted = false;
  std::string render(HtmlContext& context) const;
};

/// What the reader must know first. Empty: says `none` instead.
struct WarningList {
  std::vector<std::string> warnings;
  std::string none = "No warnings.";
  std::string render(HtmlContext& context) const;
};

/// A few large numbers at the top of a report.
struct Figures {
  struct Entry {
    std::string value;  ///< "160"
    std::string label;  ///< "markers"
  };
  std::vector<Entry> entries;
  std::string render(HtmlContext& context) const;
};

/// Names with their values.
struct KeyValues {
  std::vector<std::pair<std::string, std::string>> entries;
  std::string render(HtmlContext& context) const;
};

/// Scrolls sideways within the page when it is too wide.
struct Table {
  struct Column {
    std::string heading;
    bool number = false;  ///< aligned right
  };
  std::string caption;
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows;  ///< short rows are filled with empty cells
  bool folded = false;  ///< shows the caption only until it is opened; always open in print
  std::string render(HtmlContext& context) const;
};

/// A drawing as inline SVG.
struct Figure {
  Canvas canvas;
  std::string title;           ///< for readers who cannot see it
  std::string caption;         ///< below it; may be empty
  double least_width = 620.0;  ///< scrolls sideways below that many pixels
  bool folded = false;         ///< shows the title only until it is opened
  std::string render(HtmlContext& context) const;
};

/// A raster picture, such as a rendered scene.
struct Picture {
  Image image;
  std::string title;
  std::string caption;
  std::string render(HtmlContext& context) const;
};

/// Text to be copied (TOML, a command, a list of hashes) with a button that does so.
struct CodeBlock {
  std::string caption;
  std::string text;
  bool folded = false;
  std::string render(HtmlContext& context) const;
};

}  // namespace kinemesh
