#include "report/image.h"

#include <algorithm>
#include <cmath>

#include "config/output_file.h"

namespace kinemesh {

Image::Image(int w, int h, const Colour& fill)
    : width(w), height(h), rgba(4 * static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {
  const auto byte = [](double c) {
    return static_cast<uint8_t>(std::lround(std::clamp(c, 0.0, 1.0) * 255.0));
  };
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    rgba[i] = byte(fill.r);
    rgba[i + 1] = byte(fill.g);
    rgba[i + 2] = byte(fill.b);
    rgba[i + 3] = byte(fill.a);
  }
}

Colour Image::colour_at(int x, int y) const {
  const uint8_t* p = pixel(x, y);
  return {p[0] / 255.0, p[1] / 255.0, p[2] / 255.0, p[3] / 255.0};
}

void write_png(const std::filesystem::path& path, const Image& image) {
  write_file(path, encode_png(image));
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      word = word << 8U | (k < count ? static_cast<uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += k <= count ? digits[(word >> (18U - 6U * static_cast<unsigned>(k))) & 63U] : '=';
    }
  }
  return out;
}

}  // namespace kinemesh
