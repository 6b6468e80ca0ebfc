// The operations of a Canvas, shared by its two outputs. Private to report/.
#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "report/canvas.h"

namespace kinemesh::drawing {

struct Rectangles {
  std::vector<Box> boxes;
  Colour fill;
};
struct Path {
  std::vector<Eigen::Vector2d> points;
  bool pairs = false;   ///< each two points are a line of their own
  bool closed = false;  ///< filled with `stroke.colour` instead of stroked
  Stroke stroke;
};
struct Circle {
  Eigen::Vector2d centre;
  double radius;
  Colour fill;
};
struct Text {
  Eigen::Vector2d at;
  std::string text;
  TextStyle style;
};
struct Picture {
  Box box;
  Image image;
};
struct BeginClip {
  Box box;
};
struct EndClip {};
using Operation = std::variant<Rectangles, Path, Circle, Text, Picture, BeginClip, EndClip>;

/// Distance from the anchor down to the baseline.
inline double baseline_offset(const TextStyle& style) {
  switch (style.anchor) {
    case TextAnchor::top: return 0.93 * style.size;  // DejaVu's ascent
    case TextAnchor::middle: return 0.36 * style.size;
    case TextAnchor::bottom: return -0.24 * style.size;
    default: return 0.0;
  }
}

std::string to_svg(double width, double height, const std::vector<Operation>& operations,
                   const SvgText& text, std::string_view id_prefix);
Image to_image(double width, double height, const std::vector<Operation>& operations, double scale);

}  // namespace kinemesh::drawing
