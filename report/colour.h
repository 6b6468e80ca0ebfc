// Colours and colour maps for pictures and charts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace kinemesh {

/// sRGB components in [0, 1].
struct Colour {
  double r = 0.0, g = 0.0, b = 0.0, a = 1.0;
};

/// 0xRRGGBB.
constexpr Colour colour_from_hex(uint32_t hex) {
  return {((hex >> 16U) & 255U) / 255.0, ((hex >> 8U) & 255U) / 255.0, (hex & 255U) / 255.0, 1.0};
}

/// Perceptually ordered map (viridis) for t in [0, 1]; values outside are clamped.
Colour viridis(double t);
/// Diverging blue–white–red map for t in [-1, 1]; values outside are clamped.
Colour blue_white_red(double t);
/// Linear mix of two colours; t = 0 gives a.
Colour mix(const Colour& a, const Colour& b, double t);

/// The i-th colour for lines and bars, after Okabe and Ito (2008): told apart with any kind of
/// colour vision; repeats after seven.
Colour series_colour(std::size_t i);
/// Colours with one meaning in all pictures.
constexpr Colour missing_colour = colour_from_hex(0xc0392b);
constexpr Colour filled_colour = colour_from_hex(0xe07b00);
constexpr Colour text_colour = colour_from_hex(0x1f2328);
constexpr Colour muted_colour = colour_from_hex(0x59636e);
constexpr Colour grid_colour = colour_from_hex(0xe3e7eb);

/// How values become colours, and what they are: for meshes, strips and colour bars alike.
struct ColourScale {
  enum class Map { sequential, diverging };
  Map map = Map::sequential;  ///< diverging: white lies midway between low and high
  double low = 0.0;
  double high = 1.0;
  std::string label;  ///< "strain"
  std::string unit;   ///< "mm", "%"; empty for a pure number
  /// Values outside are clamped; NaN (no data) is grey.
  Colour operator()(double value) const;
};

}  // namespace kinemesh
