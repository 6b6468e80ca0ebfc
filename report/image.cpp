#include "report/image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/output_file.h"

namespace kinemesh {

Image::Image(int w, int h, const Colour& fill)
    : width(w), height(h), rgba(4 * static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {
  const auto byte = [](double c) {
    return static_cast<uint8_t>(std::lround(std::clamp(c, 0.0, 1.0) * 255.0));
  };
  const std::array<uint8_t, 4> pixel_bytes = {byte(fill.r), byte(fill.g), byte(fill.b),
                                              byte(fill.a)};
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    std::copy(pixel_bytes.begin(), pixel_bytes.end(),
              rgba.begin() + static_cast<std::ptrdiff_t>(i));
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
