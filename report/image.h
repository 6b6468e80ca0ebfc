// Raster images, and PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "report/colour.h"

namespace kinemesh {

/// Rows from the top, each pixel r, g, b, a in sRGB, 8 bits each, alpha not premultiplied.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> rgba;  ///< height × width × 4

  Image() = default;
  Image(int w, int h, const Colour& fill = {1, 1, 1, 1});
  uint8_t* pixel(int x, int y) {
    return rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                              static_cast<std::size_t>(x));
  }
  const uint8_t* pixel(int x, int y) const { return const_cast<Image*>(this)->pixel(x, y); }
  Colour colour_at(int x, int y) const;
};

/// The image as a PNG file's bytes.
std::string encode_png(const Image& image);
/// Throws InputError when the bytes are no readable PNG, or one over 64 megapixels.
Image decode_png(std::string_view bytes);
/// Writes a PNG file whole or not at all. Throws InputError when it cannot be written.
void write_png(const std::filesystem::path& path, const Image& image);

/// RFC 4648 base64 with padding.
std::string base64(std::string_view bytes);

}  // namespace kinemesh
