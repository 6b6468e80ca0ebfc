// The one place that names Cairo: rasters, PNG files and text widths.
#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>

#include "config/error.h"
#include "config/output_file.h"
#include "report/clean_text.h"
#include "report/drawing.h"

namespace kinemesh {
namespace {

struct Destroy {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Surface = std::unique_ptr<cairo_surface_t, Destroy>;
using Context = std::unique_ptr<cairo_t, Destroy>;

constexpr std::size_t max_pixels = std::size_t{64} << 20U;

Surface new_surface(int width, int height, cairo_format_t format = CAIRO_FORMAT_ARGB32) {
  if (width < 1 || height < 1 ||
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > max_pixels) {
    throw NoResultError({.what = "a picture of " + std::to_string(width) + " × " +
                                 std::to_string(height) + " pixels cannot be drawn",
                         .remedy = "Ask for a smaller picture or for SVG"});
  }
  Surface surface(cairo_image_surface_create(format, width, height));
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  return surface;
}

bool opaque(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] != 255) return false;
  }
  return true;
}

// Cairo keeps premultiplied native-endian ARGB words, Image straight bytes.
Surface surface_of(const Image& image) {
  const bool solid = opaque(image);
  Surface surface =
      new_surface(image.width, image.height, solid ? CAIRO_FORMAT_RGB24 : CAIRO_FORMAT_ARGB32);
  cairo_surface_flush(surface.get());
  unsigned char* rows = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < image.height; ++y) {
    const uint8_t* p = image.pixel(0, y);
    unsigned char* out = rows + static_cast<std::ptrdiff_t>(y) * stride;
    for (int x = 0; x < image.width; ++x, p += 4, out += 4) {
      const uint32_t a = p[3];
      const auto times_alpha = [a, solid](uint32_t c) { return solid ? c : (c * a + 127U) / 255U; };
      const uint32_t word =
          (a << 24U) | (times_alpha(p[0]) << 16U) | (times_alpha(p[1]) << 8U) | times_alpha(p[2]);
      std::memcpy(out, &word, 4);
    }
  }
  cairo_surface_mark_dirty(surface.get());
  return surface;
}

Image image_of(cairo_surface_t* surface) {
  cairo_surface_flush(surface);
  Image image(cairo_image_surface_get_width(surface), cairo_image_surface_get_height(surface));
  const unsigned char* rows = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  const bool solid = cairo_image_surface_get_format(surface) == CAIRO_FORMAT_RGB24;
  for (int y = 0; y < image.height; ++y) {
    uint8_t* p = image.pixel(0, y);
    const unsigned char* in = rows + static_cast<std::ptrdiff_t>(y) * stride;
    for (int x = 0; x < image.width; ++x, p += 4, in += 4) {
      uint32_t word = 0;
      std::memcpy(&word, in, 4);
      const uint32_t a = solid ? 255U : word >> 24U;
      for (unsigned c = 0; c < 3; ++c) {
        const uint32_t level = (word >> (16U - 8U * c)) & 255U;
        const uint32_t straight = a == 255U ? level : a == 0 ? 0 : (level * 255U + a / 2) / a;
        p[c] = static_cast<uint8_t>(std::min(255U, straight));
      }
      p[3] = static_cast<uint8_t>(a);
    }
  }
  return image;
}

void use_font(cairo_t* c, const TextStyle& style) {
  cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(c, style.size);
}

// Widths must not depend on the raster they are later drawn to.
Context measuring_context() {
  Surface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
  Context context(cairo_create(surface.get()));
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(context.get(), options);
  cairo_font_options_destroy(options);
  return context;
}

class Painter {
 public:
  explicit Painter(cairo_t* context) : c_(context) {
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_SLIGHT);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(c_, options);
    cairo_font_options_destroy(options);
    cairo_set_line_join(c_, CAIRO_LINE_JOIN_ROUND);
  }

  void operator()(const drawing::Rectangles& r) {
    source(r.fill);
    for (const Box& b : r.boxes) cairo_rectangle(c_, b.x, b.y, b.width, b.height);
    cairo_fill(c_);
  }
  void operator()(const drawing::Path& p) {
    source(p.stroke.colour);
    for (std::size_t i = 0; i < p.points.size(); ++i) {
      const bool begins = p.pairs ? i % 2 == 0 : i == 0;
      (begins ? cairo_move_to : cairo_line_to)(c_, p.points[i].x(), p.points[i].y());
    }
    if (p.closed) {
      cairo_close_path(c_);
      cairo_fill(c_);
      return;
    }
    cairo_set_line_width(c_, p.stroke.width);
    cairo_set_dash(c_, p.stroke.dash.data(), static_cast<int>(p.stroke.dash.size()), 0.0);
    cairo_stroke(c_);
  }
  void operator()(const drawing::Circle& circle) {
    source(circle.fill);
    cairo_new_path(c_);
    cairo_arc(c_, circle.centre.x(), circle.centre.y(), circle.radius, 0.0, 2.0 * M_PI);
    cairo_fill(c_);
  }
  void operator()(const drawing::Text& t) {
    use_font(c_, t.style);
    double left = 0.0;
    if (t.style.align != TextAlign::left) {
      cairo_text_extents_t extents;
      cairo_text_extents(c_, t.text.c_str(), &extents);
      left = t.style.align == TextAlign::right ? -extents.x_advance : -0.5 * extents.x_advance;
    }
    source(t.style.colour);
    cairo_save(c_);
    cairo_translate(c_, t.at.x(), t.at.y());
    cairo_rotate(c_, -t.style.angle * M_PI / 180.0);
    cairo_move_to(c_, left, drawing::baseline_offset(t.style));
    cairo_show_text(c_, t.text.c_str());
    cairo_restore(c_);
  }
  void operator()(const drawing::Picture& p) {
    const Surface surface = surface_of(p.image);
    cairo_save(c_);
    cairo_translate(c_, p.box.x, p.box.y);
    cairo_scale(c_, p.box.width / p.image.width, p.box.height / p.image.height);
    cairo_set_source_surface(c_, surface.get(), 0.0, 0.0);
    cairo_pattern_set_extend(cairo_get_source(c_), CAIRO_EXTEND_PAD);
    cairo_rectangle(c_, 0.0, 0.0, p.image.width, p.image.height);
    cairo_fill(c_);
    cairo_restore(c_);
  }
  void operator()(const drawing::BeginClip& clip) {
    cairo_save(c_);
    cairo_rectangle(c_, clip.box.x, clip.box.y, clip.box.width, clip.box.height);
    cairo_clip(c_);
    ++open_;
  }
  void operator()(const drawing::EndClip& /*end*/) {
    if (open_ == 0) return;
    cairo_restore(c_);
    --open_;
  }

 private:
  void source(const Colour& colour) {
    cairo_set_source_rgba(c_, colour.r, colour.g, colour.b, colour.a);
  }

  cairo_t* c_;
  int open_ = 0;
};

struct PngSource {
  std::string_view bytes;
  std::size_t at = 0;
};

}  // namespace

Image drawing::to_image(double width, double height, const std::vector<Operation>& operations,
                        double scale) {
  const Surface surface = new_surface(static_cast<int>(std::lround(width * scale)),
                                      static_cast<int>(std::lround(height * scale)));
  const Context context(cairo_create(surface.get()));
  cairo_scale(context.get(), scale, scale);
  Painter painter(context.get());
  for (const Operation& operation : operations) std::visit(painter, operation);
  if (cairo_status(context.get()) != CAIRO_STATUS_SUCCESS) {
    throw InternalError(std::string("drawing failed: ") +
                        cairo_status_to_string(cairo_status(context.get())));
  }
  return image_of(surface.get());
}

double text_width(std::string_view text, const TextStyle& style) {
  thread_local const Context context = measuring_context();
  use_font(context.get(), style);
  cairo_text_extents_t extents;
  cairo_text_extents(context.get(), clean_text(text).c_str(), &extents);
  return extents.x_advance;
}

std::string encode_png(const Image& image) {
  const Surface surface = surface_of(image);
  std::string bytes;
  const auto append = [](void* into, const unsigned char* data, unsigned int length) {
    static_cast<std::string*>(into)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
  };
  if (cairo_surface_write_to_png_stream(surface.get(), append, &bytes) != CAIRO_STATUS_SUCCESS) {
    throw std::bad_alloc();
  }
  return bytes;
}

Image decode_png(std::string_view bytes) {
  // The header's size is checked first: a few bytes can promise gigabytes.
  const auto big_endian = [&](std::size_t at) {
    std::size_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8U | static_cast<uint8_t>(bytes[at + i]);
    return value;
  };
  const bool png = bytes.size() >= 24 && bytes.substr(1, 3) == "PNG";
  if (png && (big_endian(16) > max_pixels || big_endian(20) > max_pixels ||
              big_endian(16) * big_endian(20) > max_pixels)) {
    throw InputError({.what = "the PNG picture is too large"});
  }
  PngSource source{bytes};
  const auto read = [](void* from, unsigned char* data, unsigned int length) {
    auto& s = *static_cast<PngSource*>(from);
    if (s.bytes.size() - s.at < length) return CAIRO_STATUS_READ_ERROR;
    std::memcpy(data, s.bytes.data() + s.at, length);
    s.at += length;
    return CAIRO_STATUS_SUCCESS;
  };
  const Surface surface(png ? cairo_image_surface_create_from_png_stream(read, &source) : nullptr);
  if (!surface || cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) {
    throw InputError({.what = "this is no readable PNG picture"});
  }
  return image_of(surface.get());
}

}  // namespace kinemesh
