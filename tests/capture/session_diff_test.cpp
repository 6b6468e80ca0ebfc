#include "capture/session_diff.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "config/error.h"

namespace kinemesh::session_diff_test {
namespace {

MarkerSequence plain_take(std::size_t frames = 10) {
  MarkerSequence take =
      MarkerSequence::invalid(frames, {{.label = "A"}, {.label = "B"}, {.label = "A"}}, 100.0);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < 3; ++m) {
      take.position(f, m) = Eigen::Vector3f(static_cast<float>(f), static_cast<float>(m), 5.0F);
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
    }
  }
  take.events = {{"Smile", "General", "", 0.03}};
  take.analog.channels = {{"Fz", "N", ""}};
  take.analog.rate_hz = 200.0;
  take.analog.samples_per_frame = 2;
  take.analog.values = Buffer<float>(2 * frames, 3.0F);
  take.parameters.set(
      "POINT", {.name = "UNITS", .type = C3dType::text, .dimensions = {2}, .characters = "mm"});
  take.parameters.set("POINT", {.name = "USED", .type = C3dType::integer, .numbers = {3}});
  return take;
}

std::vector<std::string> messages(const SessionDiffResult& result) {
  std::vector<std::string> all;
  for (const Difference& d : result.differences) {
    all.push_back(std::string(name_of(d.kind)) + "|" + d.place + "|" + d.message);
  }
  return all;
}

TEST(SessionDiff, ATakeIsIdenticalToItself) {
  const SessionDiffResult result = diff_sessions(plain_take(), plain_take());
  EXPECT_TRUE(result.identical());
  EXPECT_EQ(diff_text(result, "a.c3d", "b.c3d"), "A: a.c3d\nB: b.c3d\nThe two hold the same.\n");
  EXPECT_TRUE(nlohmann::json::parse(diff_json(result, "a", "b"))["identical"]);
}

TEST(SessionDiff, ValuesAreNamedWithFrameAndSize) {
  MarkerSequence other = plain_take();
  other.position(3, 1)[2] += 0.5F;
  other.position(7, 1)[2] -= 0.25F;
  other.position(8, 1)[2] += 0.0005F;  // within the tolerance
  other.residuals()[other.sample(2, 2)] = 0.4F;
  other.camera_masks()[other.sample(4, 0)] = 3;
  other.flags()[other.sample(9, 0)] = 0;
  EXPECT_EQ(
      messages(diff_sessions(plain_take(), other)),
      (std::vector<std::string>{
          "validity|marker A|it is measured only in A in 1 of 10 frames (first in frame 10)",
          "camera_mask|marker A|the cameras that saw it differ in 1 of 10 frames (first in frame "
          "5)",
          "position|marker B|it lies up to 0.5 mm apart (frame 4), in 2 of 10 frames",
          "residual|marker A|its residual differs by up to 0.4 mm (frame 3), in 1 of 10 frames"}));
  EXPECT_EQ(diff_sessions(plain_take(), other, {.tolerance_mm = 1.0}).differences.size(), 2U);
}

TEST(SessionDiff, FramesAreMatchedByTheirNumber) {
  const MarkerSequence whole = plain_take(10);
  MarkerSequence part = plain_take(4);
  part.first_frame = 4;
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t m = 0; m < 3; ++m) part.position(f, m) = whole.position(f + 3, m);
  }
  EXPECT_EQ(messages(diff_sessions(whole, part)),
            (std::vector<std::string>{"frames||frames 1 to 10 in A, frames 4 to 7 in B"}));
  part.first_frame = 100;  // no frame in common
  EXPECT_EQ(diff_sessions(whole, part).differences.size(), 1U);
}

TEST(SessionDiff, MarkersEventsAnalogAndParameters) {
  MarkerSequence other = plain_take();
  other.markers()[1].label = "C";
  other.markers()[2].kind = MarkerKind::angle;
  other.rate_hz = 50.0;
  other.events = {{"Smile", "General", "", 0.05}, {"End", "", "", 0.1}};
  other.analog.values[7] = 4.0F;
  other.parameters.find("POINT", "UNITS")->characters = "cm";
  other.parameters.set("POINT", {.name = "RATE", .numbers = {50}});
  other.parameters.set("TRIAL", {.name = "X", .numbers = {1}});
  EXPECT_EQ(
      messages(diff_sessions(plain_take(), other)),
      (std::vector<std::string>{
          "rate||100 Hz in A, 50 Hz in B", "marker|marker B|it is only in A",
          "marker|marker C|it is only in B",
          "marker|marker A|it is of kind marker in A, angle in B",
          "event|event Smile|'Smile', General at 0.030 s in A comes at 0.050 s in B",
          "event|event End|'End' at 0.100 s is only in B",
          "analog|analog channel Fz|its values differ by up to 1 N (frame 4), in 1 of 20 samples",
          "parameter|parameter POINT:RATE|it is only in B: 50",
          "parameter|parameter group TRIAL|it is only in B",
          "parameter|parameter POINT:UNITS|'mm' in A, 'cm' in B"}));
  EXPECT_THROW(diff_sessions(other, other, {.tolerance_mm = -1}), UsageError);
}

TEST(SessionDiff, AnotherOrderIsOneDifference) {
  const MarkerSequence take = plain_take();
  const std::vector<std::size_t> order{1, 0, 2};
  MarkerSequence other = take.select(order);
  other.analog = take.analog;
  other.parameters = take.parameters;
  EXPECT_EQ(messages(diff_sessions(take, other)),
            std::vector<std::string>{"order||the markers come in another order"});
}

}  // namespace
}  // namespace kinemesh::session_diff_test
