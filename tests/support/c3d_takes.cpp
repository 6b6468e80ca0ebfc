#include "tests/support/c3d_takes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace kinemesh::test {

MarkerSequence make_take(std::size_t frames, std::size_t markers) {
  std::vector<Marker> all;
  for (std::size_t m = 0; m < markers; ++m) all.push_back({.label = "M" + std::to_string(m + 1)});
  MarkerSequence take(frames, std::move(all), 100.0);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < markers; ++m) {
      const std::size_t i = take.sample(f, m);
      const double angle = 0.01 * static_cast<double>(f) + static_cast<double>(m);
      const auto grid = [](double mm) { return static_cast<float>(std::round(16.0 * mm) / 16.0); };
      take.position(f, m) =
          Eigen::Vector3f(grid(500.0 * std::cos(angle)), grid(500.0 * std::sin(angle)),
                          grid(100.0 + static_cast<double>(m % 50)));
      const bool valid = i % 7 != 3;
      take.flags()[i] = valid ? SampleFlag::valid : 0;
      take.residuals()[i] = valid ? static_cast<float>(i % 32) / 16.0F : 0.0F;
      take.camera_masks()[i] = valid ? static_cast<uint8_t>(i % 128) : uint8_t{0};
    }
  }
  take.origin.scale = -1.0 / 16.0;
  take.origin.path = "made for a test";
  return take;
}

void add_analog(MarkerSequence& take, std::size_t channels, std::size_t samples) {
  for (std::size_t c = 0; c < channels; ++c)
    take.analog.channels.push_back({.label = "A" + std::to_string(c + 1), .unit = "V"});
  take.analog.samples_per_frame = samples;
  take.analog.rate_hz = take.rate_hz * static_cast<double>(samples);
  take.analog.values = Buffer<float>(take.frame_count() * samples * channels);
  for (std::size_t i = 0; i < take.analog.values.size(); ++i)
    take.analog.values[i] = static_cast<float>(static_cast<int>(i % 4001) - 2000);
}

C3dReadResult read_encoded(const std::string& bytes, const C3dReadOptions& options) {
  return read_c3d(std::as_bytes(std::span(bytes)), "test.c3d", options);
}

std::size_t place_of(const std::string& bytes, const std::string& group, const std::string& name) {
  const C3dHeadResult head = read_c3d_head(std::as_bytes(std::span(bytes)), "test.c3d");
  const auto it = std::ranges::find_if(head.layout.places, [&](const C3dParameterPlace& p) {
    return p.group == group && p.name == name;
  });
  EXPECT_NE(it, head.layout.places.end()) << group << ":" << name;
  return it == head.layout.places.end() ? 0 : it->data;
}

void expect_same_take(const MarkerSequence& a, const MarkerSequence& b, float position_tolerance,
                      float residual_tolerance, float analog_tolerance) {
  EXPECT_EQ(a.markers(), b.markers());
  EXPECT_EQ(a.rate_hz, b.rate_hz);
  EXPECT_EQ(a.first_frame, b.first_frame);
  EXPECT_EQ(a.events, b.events);
  ASSERT_EQ(a.frame_count(), b.frame_count());
  ASSERT_EQ(a.sample_count(), b.sample_count());
  for (std::size_t i = 0; i < a.sample_count(); ++i) {
    ASSERT_EQ(a.flags()[i] & SampleFlag::valid, b.flags()[i] & SampleFlag::valid) << "sample " << i;
    if (a.flags()[i] == 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_NEAR(a.positions()[3 * i + k], b.positions()[3 * i + k], position_tolerance)
          << "sample " << i;
    ASSERT_NEAR(a.residuals()[i], b.residuals()[i], residual_tolerance) << "sample " << i;
    ASSERT_EQ(a.camera_masks()[i], b.camera_masks()[i]) << "sample " << i;
  }
  EXPECT_EQ(a.analog.channels, b.analog.channels);
  EXPECT_EQ(a.analog.samples_per_frame, b.analog.samples_per_frame);
  ASSERT_EQ(a.analog.values.size(), b.analog.values.size());
  for (std::size_t i = 0; i < a.analog.values.size(); ++i) {
    const float x = a.analog.values[i];
    const float y = b.analog.values[i];
    ASSERT_TRUE(std::abs(x - y) <= analog_tolerance || (std::isnan(x) && std::isnan(y)))
        << "analog " << i << ": " << x << ", " << y;
  }
}

bool has_finding(const C3dReadResult& r, std::string_view code) {
  return std::ranges::any_of(r.findings, [&](const C3dFinding& f) { return f.code == code; });
}

}  // namespace kinemesh::test
