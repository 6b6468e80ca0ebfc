#include "report/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace kinemesh {

Colour mix(const Colour& a, const Colour& b, double t) {
  const auto between = [t](double x, double y) { return x + t * (y - x); };
  return {between(a.r, b.r), between(a.g, b.g), between(a.b, b.b), between(a.a, b.a)};
}

Colour viridis(double t) {
  // Nine equidistant samples of matplotlib's viridis; between them it is close to linear.
  static constexpr std::array<uint32_t, 9> samples = {
      0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725};
  const double at = std::clamp(std::isnan(t) ? 0.0 : t, 0.0, 1.0) * (samples.size() - 1);
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(at), samples.size() - 2);
  return mix(colour_from_hex(samples[i]), colour_from_hex(samples[i + 1]),
             at - static_cast<double>(i));
}

Colour blue_white_red(double t) {
  constexpr Colour blue = colour_from_hex(0x2b5fab);
  constexpr Colour white = colour_from_hex(0xf7f7f7);
  constexpr Colour red = colour_from_hex(0xb2182b);
  const double at = std::clamp(std::isnan(t) ? 0.0 : t, -1.0, 1.0);
  return at < 0 ? mix(white, blue, -at) : mix(white, red, at);
}

Colour series_colour(std::size_t i) {
  static constexpr std::array<uint32_t, 7> colours = {0x0072b2, 0xd55e00, 0x009e73, 0xe69f00,
                                                      0xcc79a7, 0x56b4e9, 0x555555};
  return colour_from_hex(colours[i % colours.size()]);
}

Colour ColourScale::operator()(double value) const {
  if (std::isnan(value)) return colour_from_hex(0xb8bec4);
  const double span = high - low;
  const double t = span > 0.0 ? (value - low) / span : value > high ? 1.0 : 0.0;
  return map == Map::sequential ? viridis(t) : blue_white_red(2.0 * t - 1.0);
}

}  // namespace kinemesh
