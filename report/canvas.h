// Vector drawing: what is drawn once comes out as PNG and as SVG. Lengths are pixels at scale 1,
// the origin is the top left corner, y points down.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "report/colour.h"
#include "report/image.h"

namespace kinemesh {

struct Box {
  double x = 0.0, y = 0.0, width = 0.0, height = 0.0;
  double right() const { return x + width; }
  double bottom() const { return y + height; }
  Box inset(double left, double top, double right_side, double bottom_side) const {
    return {x + left, y + top, width - left - right_side, height - top - bottom_side};
  }
};

enum class TextAlign { left, centre, right };
enum class TextAnchor { baseline, top, middle, bottom };

struct TextStyle {
  double size = 12.0;
  Colour colour = colour_from_hex(0x1f2328);
  bool bold = false;
  TextAlign align = TextAlign::left;
  TextAnchor anchor = TextAnchor::baseline;
  double angle = 0.0;  ///< degrees, counter-clockwise, about the anchor point
};

struct Stroke {
  Colour colour = colour_from_hex(0x1f2328);
  double width = 1.0;
  std::vector<double> dash{};  ///< lengths on, off, on, …; empty for a solid line
};

/// Names an SVG for readers that cannot see it.
struct SvgText {
  std::string title{};
  std::string description{};
};

/// A list of drawing operations, in the order in which they cover each other. Any bytes are
/// allowed in texts (see clean_text). Not for use by several threads at once.
class Canvas {
 public:
  Canvas(double width, double height, const Colour& background = {1, 1, 1, 1});
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;
  ~Canvas();

  double width() const;
  double height() const;

  void rectangle(const Box& box, const Colour& fill) { rectangles({box}, fill); }
  /// Many of one colour at once: much smaller and faster than one by one.
  void rectangles(std::vector<Box> boxes, const Colour& fill);
  void outline(const Box& box, const Stroke& stroke);
  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Stroke& stroke);
  /// Several lines of one style; each pair of points is one line.
  void lines(std::vector<Eigen::Vector2d> ends, const Stroke& stroke);
  void polyline(std::vector<Eigen::Vector2d> points, const Stroke& stroke);
  void polygon(std::vector<Eigen::Vector2d> points, const Colour& fill);
  void circle(const Eigen::Vector2d& centre, double radius, const Colour& fill);
  void text(const Eigen::Vector2d& at, std::string_view text, const TextStyle& style = {});
  /// Text that is clipped with an ellipsis to fit `max_width`.
  void text_within(const Eigen::Vector2d& at, std::string_view text, double max_width,
                   const TextStyle& style = {});
  /// The image stretched over the box.
  void image(const Box& box, Image image);
  /// Only what lies inside the box is drawn until end_clip().
  void begin_clip(const Box& box);
  void end_clip();

  /// The drawing at `scale` pixels per unit.
  Image raster(double scale = 1.0) const;
  /// A whole <svg> element, with real text; `id_prefix` keeps ids apart when several are put into
  /// one HTML page.
  std::string svg(const SvgText& text = {}, std::string_view id_prefix = "k") const;

  /// The bytes of files that write_png and write_svg write.
  std::string png_file(double scale = 2.0) const;
  std::string svg_file(const SvgText& text = {}) const;
  void write_png(const std::filesystem::path& path, double scale = 2.0) const;
  void write_svg(const std::filesystem::path& path, const SvgText& text = {}) const;

 private:
  struct Drawing;
  std::unique_ptr<Drawing> drawing_;
};

/// Width in pixels of a text in the font that Canvas uses (DejaVu Sans).
double text_width(std::string_view text, const TextStyle& style = {});

}  // namespace kinemesh
