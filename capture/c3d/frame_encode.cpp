#include "capture/c3d/frame_encode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "capture/c3d/number_format.h"

namespace kinemesh {
namespace {

/// A stored float that `decode` turns into exactly `value`, if the quotient or one of its
/// neighbours does; otherwise the quotient.
template <class Decode>
float stored_for(float value, float quotient, Decode decode) {
  if (decode(quotient) == value || !std::isfinite(quotient)) return quotient;
  float up = quotient;
  float down = quotient;
  for (int step = 0; step < 4; ++step) {
    up = std::nextafter(up, std::numeric_limits<float>::infinity());
    down = std::nextafter(down, -std::numeric_limits<float>::infinity());
    if (decode(up) == value) return up;
    if (decode(down) == value) return down;
  }
  return quotient;
}

int16_t rounded_word(double value, std::size_t& clipped) {
  if (!std::isfinite(value)) return 0;
  const double kept = std::clamp(std::round(value), -32768.0, 32767.0);
  if (kept != std::round(value)) ++clipped;
  return static_cast<int16_t>(kept);
}

}  // namespace

FrameEncoder::FrameEncoder(const MarkerSequence& take, const C3dWritePlan& plan)
    : take_(take),
      plan_(plan),
      analog_values_(plan.analog.channels.size() * take.analog.samples_per_frame),
      frame_bytes_((4 * plan.points + analog_values_) * (plan.storage == Storage::real ? 4 : 2)) {}

/// The fourth word: camera mask and residual, or -1 where the point is invalid.
int FrameEncoder::word_of(std::size_t point, const Sample& s, EncodeTally& tally) const {
  if (!s.valid) return -1;
  const double step = std::abs(plan_.scale) * static_cast<double>(plan_.to_mm[point]);
  const double exact = std::isfinite(s.residual) ? std::max(0.0F, s.residual) / step : 0.0;
  const double steps = std::min(std::round(exact), 255.0);
  if (std::round(exact) > 255.0) ++tally.clipped_residuals;
  if (std::abs(exact - std::round(exact)) > 1e-3) ++tally.rounded_residuals;
  if ((s.cameras & 0x80U) != 0) ++tally.lost_cameras;
  return (static_cast<int>(s.cameras & 0x7FU) << 8) | static_cast<int>(steps);
}

void FrameEncoder::encode_point(std::size_t point, const Sample& s, std::byte* to,
                                EncodeTally& tally) const {
  const int word = word_of(point, s, tally);
  const float factor = plan_.to_mm[point];
  if (s.valid && s.position[0] == 0.0F && s.position[1] == 0.0F && s.position[2] == 0.0F)
    ++tally.ambiguous_zeros;
  if (plan_.storage == Storage::integer) {
    const double step = static_cast<double>(static_cast<float>(std::abs(plan_.scale)) * factor);
    std::array<int16_t, 4> words{};
    std::size_t ignored = 0;
    for (std::size_t k = 0; k < 3; ++k)
      words[k] = rounded_word(s.position[k] / step, s.valid ? tally.clipped_coordinates : ignored);
    words[3] = static_cast<int16_t>(word);
    std::memcpy(to, words.data(), sizeof words);
    return;
  }
  std::array<float, 4> reals{};
  for (std::size_t k = 0; k < 3; ++k) {
    const float value = s.position[k];
    reals[k] = factor == 1.0F
                   ? value
                   : stored_for(value, value / factor, [factor](float z) { return z * factor; });
  }
  reals[3] = static_cast<float>(word);
  std::memcpy(to, reals.data(), sizeof reals);
}

void FrameEncoder::encode_points(std::size_t frame, std::byte* to, EncodeTally& tally) const {
  const std::size_t point_bytes = plan_.storage == Storage::real ? 16 : 8;
  const std::size_t markers = take_.marker_count();
  for (std::size_t m = 0; m < markers; ++m) {
    const std::size_t i = take_.sample(frame, m);
    const uint8_t flags = take_.flags()[i];
    const bool filled = (flags & SampleFlag::filled) != 0;
    // A residual of 0 says that the point was interpolated.
    encode_point(
        m,
        {take_.positions().data() + 3 * i, (flags & SampleFlag::valid) != 0,
         filled ? 0.0F : take_.residuals()[i], filled ? uint8_t{0} : take_.camera_masks()[i]},
        to, tally);
    to += point_bytes;
  }
  if (plan_.unlabelled == 0) return;
  const UnlabelledPoints& free = take_.unlabelled;
  const std::size_t begin = free.offsets[frame];
  const std::size_t count = free.offsets[frame + 1] - begin;
  constexpr std::array<float, 3> nowhere{};
  for (std::size_t u = 0; u < plan_.unlabelled; ++u) {
    const std::size_t i = begin + u;
    const bool there = u < count;
    const Sample sample{there ? free.positions[i].data() : nowhere.data(), there,
                        there && i < free.residuals.size() ? free.residuals[i] : 0.0F,
                        there && i < free.camera_masks.size() ? free.camera_masks[i] : uint8_t{0}};
    encode_point(markers + u, sample, to, tally);
    to += point_bytes;
  }
}

void FrameEncoder::encode_analog(std::size_t frame, std::byte* to) const {
  const float* values = take_.analog.values.data() + frame * analog_values_;
  const std::size_t channels = plan_.analog.channels.size();
  for (std::size_t i = 0; i < analog_values_; ++i) {
    const double offset = plan_.analog.offsets[i % channels];
    const double factor = plan_.analog.factors[i % channels];
    const double raw = factor == 0.0 ? offset : static_cast<double>(values[i]) / factor + offset;
    if (plan_.storage == Storage::real) {
      const float stored = stored_for(values[i], static_cast<float>(raw), [=](float z) {
        return static_cast<float>((static_cast<double>(z) - offset) * factor);
      });
      std::memcpy(to + 4 * i, &stored, 4);
    } else {
      const double low = plan_.analog.unsigned_samples ? 0.0 : -32768.0;
      const double kept =
          std::isfinite(raw) ? std::clamp(std::round(raw), low, low + 65535.0) : 0.0;
      const auto stored = static_cast<uint16_t>(static_cast<int32_t>(kept) & 0xFFFF);
      std::memcpy(to + 2 * i, &stored, 2);
    }
  }
}

void FrameEncoder::encode(std::size_t frame, std::byte* to, EncodeTally& tally) const {
  encode_points(frame, to, tally);
  const std::size_t width = plan_.storage == Storage::real ? 4 : 2;
  if (analog_values_ > 0) encode_analog(frame, to + 4 * plan_.points * width);
  if (plan_.storage == Storage::real) {
    reals_from_native(to, frame_bytes_ / 4, plan_.processor);
  } else {
    swap_words(to, frame_bytes_ / 2, plan_.processor);
  }
}

}  // namespace kinemesh
