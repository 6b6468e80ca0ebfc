#include "capture/c3d/point_decode.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "config/multiversion.h"

namespace kinemesh {
namespace {

// Four lanes of one point. Compilers map them to whatever vectors the target has.
using Float4 = float __attribute__((vector_size(16)));
using Short4 = int16_t __attribute__((vector_size(8)));
using Int4 = int32_t __attribute__((vector_size(16)));

constexpr float sentinel = -16512.0F;
constexpr float far_away_mm = 1e6F;

/// What one frame had, for PointOccurrences.
struct Tally {
  uint32_t zero_gaps = 0, not_finite = 0, unsigned_minus_one = 0, odd_words = 0, sentinels = 0,
           far_away = 0;
};

struct FrameShape {
  std::size_t points;
  const float* position_scales;
  const float* residual_scales;
  const float* far_limits;
  const uint32_t* zero_is_gap;
};

// Each point's four lanes are stored at once; the fourth lands where the next point's x follows.
// The last point is stored alone.

void copy_positions(const float* stored, std::size_t points, float* to) {
  for (std::size_t i = 0; i + 1 < points; ++i) std::memcpy(to + 3 * i, stored + 4 * i, 16);
  if (points > 0) std::memcpy(to + 3 * (points - 1), stored + 4 * (points - 1), 12);
}

void scale_positions(const float* stored, const FrameShape& shape, float* to) {
  for (std::size_t i = 0; i < shape.points; ++i) {
    Float4 v;
    std::memcpy(&v, stored + 4 * i, 16);
    v *= shape.position_scales[i];
    std::memcpy(to + 3 * i, &v, i + 1 < shape.points ? 16 : 12);
  }
}

KINEMESH_MULTIVERSION void scale_positions_of_integers(const int16_t* stored,
                                                       const FrameShape& shape, float* to) {
  for (std::size_t i = 0; i < shape.points; ++i) {
    Short4 s;
    std::memcpy(&s, stored + 4 * i, 8);
    Float4 v = __builtin_convertvector(__builtin_convertvector(s, Int4), Float4);
    v *= shape.position_scales[i];
    if (i + 1 < shape.points) {
      std::memcpy(to + 3 * i, &v, 16);
    } else {
      std::memcpy(to + 3 * i, &v, 12);
    }
  }
}

KINEMESH_MULTIVERSION Tally decode_reals(const float* stored, const FrameShape& shape,
                                         uint8_t* flags, float* residuals, uint8_t* masks) {
  Tally t;
  constexpr float largest = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < shape.points; ++i) {
    const float x = stored[4 * i];
    const float y = stored[4 * i + 1];
    const float z = stored[4 * i + 2];
    const float w = stored[4 * i + 3];
    // As a 16-bit integer the word would be truncated towards zero.
    const uint32_t word_valid =
        static_cast<uint32_t>(w > -1.0F) & static_cast<uint32_t>(w < 32768.0F);
    const auto word = static_cast<int32_t>(word_valid != 0 ? w : 0.0F);
    const float reach = std::fabs(x) + std::fabs(y) + std::fabs(z);
    const auto finite = static_cast<uint32_t>(std::fabs(x) <= largest) &
                        static_cast<uint32_t>(std::fabs(y) <= largest) &
                        static_cast<uint32_t>(std::fabs(z) <= largest);
    const uint32_t zero = static_cast<uint32_t>(reach == 0.0F) & shape.zero_is_gap[i];
    const auto gone = static_cast<uint32_t>(x == sentinel) & static_cast<uint32_t>(y == sentinel) &
                      static_cast<uint32_t>(z == sentinel);
    const uint32_t valid = word_valid & finite & (1U ^ zero) & (1U ^ gone);
    const int32_t kept = valid != 0 ? word : 0;
    flags[i] = static_cast<uint8_t>(valid);
    residuals[i] = static_cast<float>(kept & 0xFF) * shape.residual_scales[i];
    masks[i] = static_cast<uint8_t>(kept >> 8);
    t.zero_gaps += word_valid & zero;
    t.not_finite += word_valid & (1U ^ finite);
    t.unsigned_minus_one += static_cast<uint32_t>(w == 65535.0F);
    t.odd_words += static_cast<uint32_t>(!(w < 32768.0F)) & static_cast<uint32_t>(w != 65535.0F);
    t.sentinels += word_valid & gone;
    t.far_away += valid & static_cast<uint32_t>(reach > shape.far_limits[i]);
  }
  return t;
}

KINEMESH_MULTIVERSION Tally decode_integers(const int16_t* stored, const FrameShape& shape,
                                            uint8_t* flags, float* residuals, uint8_t* masks) {
  Tally t;
  constexpr int32_t gone_at = -16512;
  for (std::size_t i = 0; i < shape.points; ++i) {
    const int32_t x = stored[4 * i];
    const int32_t y = stored[4 * i + 1];
    const int32_t z = stored[4 * i + 2];
    const int32_t w = stored[4 * i + 3];
    const auto word_valid = static_cast<uint32_t>(w >= 0);
    const uint32_t zero = static_cast<uint32_t>((x | y | z) == 0) & shape.zero_is_gap[i];
    const auto gone = static_cast<uint32_t>(x == gone_at) & static_cast<uint32_t>(y == gone_at) &
                      static_cast<uint32_t>(z == gone_at);
    const uint32_t valid = word_valid & (1U ^ zero) & (1U ^ gone);
    const int32_t kept = valid != 0 ? w : 0;
    flags[i] = static_cast<uint8_t>(valid);
    residuals[i] = static_cast<float>(kept & 0xFF) * shape.residual_scales[i];
    masks[i] = static_cast<uint8_t>(kept >> 8);
    t.zero_gaps += word_valid & zero;
    t.sentinels += word_valid & gone;
  }
  return t;
}

KINEMESH_MULTIVERSION void scale_reals(const std::byte* stored, std::size_t count,
                                       const double* offsets, const double* factors, float* to) {
  for (std::size_t i = 0; i < count; ++i) {
    float v = 0.0F;
    std::memcpy(&v, stored + 4 * i, 4);
    to[i] = static_cast<float>((static_cast<double>(v) - offsets[i]) * factors[i]);
  }
}

template <class Sample>
inline void scale_integers(const std::byte* stored, std::size_t count, const double* offsets,
                           const double* factors, float* to) {
  for (std::size_t i = 0; i < count; ++i) {
    Sample v = 0;
    std::memcpy(&v, stored + 2 * i, 2);
    to[i] = static_cast<float>((static_cast<double>(v) - offsets[i]) * factors[i]);
  }
}

KINEMESH_MULTIVERSION void scale_signed(const std::byte* stored, std::size_t count,
                                        const double* offsets, const double* factors, float* to) {
  scale_integers<int16_t>(stored, count, offsets, factors, to);
}

KINEMESH_MULTIVERSION void scale_unsigned(const std::byte* stored, std::size_t count,
                                          const double* offsets, const double* factors, float* to) {
  scale_integers<uint16_t>(stored, count, offsets, factors, to);
}

}  // namespace

PointDecoder::PointDecoder(const C3dLayout& layout, const PointTable& table, ZeroPolicy zero_points)
    : points_(table.markers.size()), storage_(layout.storage), uniform_(table.uniform) {
  const auto scale = static_cast<float>(std::abs(layout.scale));
  for (std::size_t i = 0; i < points_; ++i) {
    const float residual_scale = scale * table.to_mm[i];
    residual_scales_.push_back(residual_scale);
    position_scales_.push_back(storage_ == Storage::real ? table.to_mm[i] : residual_scale);
    far_limits_.push_back(table.zero_is_value[i] != 0 ? std::numeric_limits<float>::infinity()
                                                      : far_away_mm / position_scales_.back());
    zero_is_gap_.push_back(zero_points == ZeroPolicy::gap && table.zero_is_value[i] == 0 ? 1 : 0);
  }
}

void PointDecoder::decode(const void* stored, const FrameTarget& to, std::size_t frame) {
  const FrameShape shape{points_, position_scales_.data(), residual_scales_.data(),
                         far_limits_.data(), zero_is_gap_.data()};
  Tally t;
  if (storage_ == Storage::real) {
    const auto* reals = static_cast<const float*>(stored);
    if (uniform_) {
      copy_positions(reals, points_, to.positions);
    } else {
      scale_positions(reals, shape, to.positions);
    }
    t = decode_reals(reals, shape, to.flags, to.residuals, to.camera_masks);
  } else {
    const auto* integers = static_cast<const int16_t*>(stored);
    scale_positions_of_integers(integers, shape, to.positions);
    t = decode_integers(integers, shape, to.flags, to.residuals, to.camera_masks);
  }
  occurrences_.zero_gaps.add(t.zero_gaps, frame);
  occurrences_.not_finite.add(t.not_finite, frame);
  occurrences_.unsigned_minus_one.add(t.unsigned_minus_one, frame);
  occurrences_.odd_words.add(t.odd_words, frame);
  occurrences_.sentinels.add(t.sentinels, frame);
  occurrences_.far_away.add(t.far_away, frame);
}

AnalogDecoder::AnalogDecoder(const C3dLayout& layout, const AnalogTable& table)
    : storage_(layout.storage),
      unsigned_(table.unsigned_samples),
      count_(layout.analog_channels * layout.analog_samples) {
  // Loops over a handful of channels would be short: repeat the table for some samples.
  constexpr std::size_t long_enough = 1024;
  std::size_t samples = 0;
  do {
    offsets_.insert(offsets_.end(), table.offsets.begin(), table.offsets.end());
    factors_.insert(factors_.end(), table.factors.begin(), table.factors.end());
  } while (++samples < layout.analog_samples && offsets_.size() < long_enough);
  plain_ = std::ranges::all_of(table.offsets, [](double o) { return o == 0.0; }) &&
           std::ranges::all_of(table.factors, [](double f) { return f == 1.0; });
}

void AnalogDecoder::decode(const std::byte* stored, float* values) const {
  if (storage_ == Storage::real && plain_) {
    if (count_ > 0) std::memcpy(values, stored, 4 * count_);
    return;
  }
  const std::size_t width = storage_ == Storage::real ? 4 : 2;
  const auto scale = storage_ == Storage::real ? scale_reals
                     : unsigned_               ? scale_unsigned
                                               : scale_signed;
  for (std::size_t begin = 0; begin < count_; begin += offsets_.size()) {
    const std::size_t count = std::min(offsets_.size(), count_ - begin);
    scale(stored + begin * width, count, offsets_.data(), factors_.data(), values + begin);
  }
}

}  // namespace kinemesh
