#include "report/canvas.h"

#include <string>
#include <utility>
#include <vector>

#include "config/output_file.h"
#include "report/clean_text.h"
#include "report/drawing.h"

namespace kinemesh {

struct Canvas::Drawing {
  double width = 0.0;
  double height = 0.0;
  std::vector<drawing::Operation> operations;
};

Canvas::Canvas(double width, double height, const Colour& background)
    : drawing_(std::make_unique<Drawing>()) {
  drawing_->width = width;
  drawing_->height = height;
  if (background.a > 0.0) rectangle({0, 0, width, height}, background);
}
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;
Canvas::~Canvas() = default;

double Canvas::width() const { return drawing_->width; }
double Canvas::height() const { return drawing_->height; }

void Canvas::rectangles(std::vector<Box> boxes, const Colour& fill) {
  if (boxes.empty()) return;
  drawing_->operations.emplace_back(drawing::Rectangles{std::move(boxes), fill});
}

void Canvas::outline(const Box& box, const Stroke& stroke) {
  polyline({{box.x, box.y},
            {box.right(), box.y},
            {box.right(), box.bottom()},
            {box.x, box.bottom()},
            {box.x, box.y}},
           stroke);
}

void Canvas::line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Stroke& stroke) {
  polyline({from, to}, stroke);
}

void Canvas::lines(std::vector<Eigen::Vector2d> ends, const Stroke& stroke) {
  if (ends.size() < 2) return;
  drawing_->operations.emplace_back(
      drawing::Path{.points = std::move(ends), .pairs = true, .stroke = stroke});
}

void Canvas::polyline(std::vector<Eigen::Vector2d> points, const Stroke& stroke) {
  if (points.size() < 2) return;
  drawing_->operations.emplace_back(drawing::Path{.points = std::move(points), .stroke = stroke});
}

void Canvas::polygon(std::vector<Eigen::Vector2d> points, const Colour& fill) {
  if (points.size() < 3) return;
  drawing_->operations.emplace_back(
      drawing::Path{.points = std::move(points), .closed = true, .stroke = {.colour = fill}});
}

void Canvas::circle(const Eigen::Vector2d& centre, double radius, const Colour& fill) {
  drawing_->operations.emplace_back(drawing::Circle{centre, radius, fill});
}

void Canvas::text(const Eigen::Vector2d& at, std::string_view text, const TextStyle& style) {
  std::string shown = clean_text(text);
  if (shown.empty()) return;
  drawing_->operations.emplace_back(drawing::Text{at, std::move(shown), style});
}

void Canvas::text_within(const Eigen::Vector2d& at, std::string_view text, double max_width,
                         const TextStyle& style) {
  const std::string whole = clean_text(text);
  if (text_width(whole, style) <= max_width) {
    this->text(at, whole, style);
    return;
  }
  std::size_t fits = 1;
  std::size_t too_many = whole.size();
  while (fits + 1 < too_many) {
    const std::size_t half = (fits + too_many) / 2;
    (text_width(shorten(whole, half), style) <= max_width ? fits : too_many) = half;
  }
  this->text(at, shorten(whole, fits), style);
}

void Canvas::image(const Box& box, Image image) {
  if (image.width <= 0 || image.height <= 0) return;
  drawing_->operations.emplace_back(drawing::Picture{box, std::move(image)});
}

void Canvas::begin_clip(const Box& box) {
  drawing_->operations.emplace_back(drawing::BeginClip{box});
}

void Canvas::end_clip() { drawing_->operations.emplace_back(drawing::EndClip{}); }

Image Canvas::raster(double scale) const {
  return drawing::to_image(width(), height(), drawing_->operations, scale);
}

std::string Canvas::svg(const SvgText& text, std::string_view id_prefix) const {
  return drawing::to_svg(width(), height(), drawing_->operations, text, id_prefix);
}

std::string Canvas::png_file(double scale) const { return encode_png(raster(scale)); }

std::string Canvas::svg_file(const SvgText& text) const {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + svg(text);
}

void Canvas::write_png(const std::filesystem::path& path, double scale) const {
  write_file(path, png_file(scale));
}

void Canvas::write_svg(const std::filesystem::path& path, const SvgText& text) const {
  write_file(path, svg_file(text));
}

}  // namespace kinemesh
