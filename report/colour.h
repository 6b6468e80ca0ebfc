// Colours and colour maps for pictures and charts.
#pragma once

#include <cstdint>

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

}  // namespace kinemesh
