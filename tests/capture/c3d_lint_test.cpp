#include "capture/c3d/lint.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/c3d/summary.h"

namespace kinemesh::c3d_lint_test {
namespace {

/// Four markers that move within half a metre, with residuals: nothing to say about it.
MarkerSequence healthy_take(std::size_t frames = 300) {
  MarkerSequence take = MarkerSequence::invalid(frames,
                                                {{.label = "A"},
                                                 {.label = "B"},
                                                 {.label = "C", .subject = "S"},
                                                 {.label = "P", .kind = MarkerKind::power}},
                                                100.0);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < 4; ++m) {
      take.position(f, m) =
          Eigen::Vector3f(static_cast<float>(f), 100.0F * static_cast<float>(m), 5.0F);
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
      take.residuals()[take.sample(f, m)] = 0.3F;
    }
  }
  return take;
}

std::vector<std::string> codes(const MarkerSequence& take, const C3dLayout& layout = {}) {
  std::vector<std::string> all;
  for (const C3dFinding& f : lint_session(take, &layout)) all.push_back(f.code);
  return all;
}

using Codes = std::vector<std::string>;

TEST(C3dLint, HealthyTakesHaveNoFindings) { EXPECT_EQ(codes(healthy_take()), Codes()); }

TEST(C3dLint, C3D701MarkerNeverMeasured) {
  MarkerSequence take = healthy_take();
  for (std::size_t f = 0; f < take.frame_count(); ++f) take.flags()[take.sample(f, 2)] = 0;
  const C3dLayout layout;
  const std::vector<C3dFinding> findings = lint_session(take, &layout);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].code, "C3D701");
  EXPECT_EQ(findings[0].place, "marker S:C");
  EXPECT_EQ(findings[0].message, "1 marker of 3 has no position in any frame");
}

TEST(C3dLint, C3D702MarkerMostlyMissing) {
  MarkerSequence take = healthy_take();
  for (std::size_t f = 0; f < 151; ++f) take.flags()[take.sample(f, 0)] = 0;
  EXPECT_EQ(codes(take), Codes{"C3D702"});
  take.flags()[take.sample(0, 0)] = SampleFlag::valid;
  EXPECT_EQ(codes(take), Codes());
}

TEST(C3dLint, C3D703AllResidualsZero) {
  MarkerSequence take = healthy_take();
  std::ranges::fill(take.residuals(), 0.0F);
  EXPECT_EQ(codes(take), Codes{"C3D703"});
  EXPECT_TRUE(lint_session(take, nullptr).empty());  // a table has no residuals
}

TEST(C3dLint, C3D704UnusualRate) {
  MarkerSequence take = healthy_take();
  take.rate_hz = 1.0;
  EXPECT_EQ(codes(take), Codes{"C3D704"});
  take.rate_hz = 90000.0;
  EXPECT_EQ(codes(take), Codes{"C3D704"});
}

TEST(C3dLint, C3D705ExtentAgainstUnit) {
  MarkerSequence take = healthy_take();
  for (float& v : take.positions()) v *= 0.001F;  // metres declared as mm
  EXPECT_EQ(codes(take), Codes{"C3D705"});
  for (float& v : take.positions()) v *= 1e6F;
  EXPECT_EQ(codes(take), Codes{"C3D705"});
}

TEST(C3dLint, C3D706And707IntegerRangeAndStep) {
  MarkerSequence take = healthy_take();
  C3dLayout layout;
  layout.storage = Storage::integer;
  layout.scale = 0.1;
  EXPECT_EQ(codes(take, layout), Codes());
  take.position(5, 1)[0] = -3276.7F;
  EXPECT_EQ(codes(take, layout), Codes{"C3D706"});
  layout.scale = 0.6;
  EXPECT_EQ(codes(take, layout), Codes{"C3D707"});
}

TEST(C3dLint, C3D708FrozenMarker) {
  MarkerSequence take = healthy_take();
  for (std::size_t f = 100; f < 250; ++f) take.position(f, 1) = take.position(100, 1);
  const C3dLayout layout;
  const std::vector<C3dFinding> findings = lint_session(take, &layout);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].code, "C3D708");
  EXPECT_EQ(findings[0].message, "1 marker repeats exactly one position for up to 1.5 s");
}

TEST(C3dLint, C3D709EventTwice) {
  MarkerSequence take = healthy_take();
  take.events = {{"Smile", "", "", 0.5}, {"Smile", "Left", "", 0.5}};
  EXPECT_EQ(codes(take), Codes());
  take.events.push_back({"Smile", "", "", 0.5});
  EXPECT_EQ(codes(take), Codes{"C3D709"});
}

TEST(C3dLint, C3D710And711ForcePlates) {
  MarkerSequence take = healthy_take();
  const auto set = [&take](const char* name, std::size_t count) {
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(i + 1);
    take.parameters.set("FORCE_PLATFORM", {.name = name, .numbers = values});
  };
  take.parameters.set("FORCE_PLATFORM", {.name = "USED", .type = C3dType::integer, .numbers = {1}});
  set("TYPE", 1);
  set("CORNERS", 12);
  set("ORIGIN", 3);
  set("CHANNEL", 6);
  take.analog.channels.resize(6);
  EXPECT_EQ(codes(take), Codes());
  take.analog.channels.resize(5);
  EXPECT_EQ(codes(take), Codes{"C3D711"});
  take.analog.channels.resize(6);
  set("CORNERS", 11);
  EXPECT_EQ(codes(take), Codes{"C3D710"});
}

TEST(C3dSummary, CountsGapsAndSaysThemInWords) {
  MarkerSequence take = healthy_take();
  for (std::size_t f = 10; f < 35; ++f) take.flags()[take.sample(f, 2)] = 0;
  for (std::size_t f = 290; f < 300; ++f) take.flags()[take.sample(f, 2)] = 0;
  take.first_frame = 11;
  take.events = {{"Smile", "General", "S", 0.51}};
  take.origin.path = "take.c3d";
  take.origin.manufacturer = "Vicon Nexus 2.5";
  take.origin.x_screen = "+X";
  take.origin.y_screen = "+Z";
  C3dLayout layout;
  layout.processor = Processor::dec;
  layout.storage = Storage::integer;
  layout.scale = 0.1;
  const C3dSummary s = summarise(take, &layout);
  EXPECT_EQ(s.subjects, std::vector<std::string>{"S"});
  EXPECT_EQ(s.duration_s, 3.0);
  EXPECT_EQ(s.markers[2].valid_frames, 265U);
  EXPECT_EQ(s.markers[2].gaps, 2U);
  EXPECT_EQ(s.markers[2].longest_gap_s, 0.25);
  EXPECT_EQ(s.missing_samples, 35U);
  EXPECT_EQ(summary_text(s),
            "take.c3d\n"
            "  Recorded with  Vicon Nexus 2.5\n"
            "  Subjects       S\n"
            "  Points         3 markers, 1 power\n"
            "  Frames         300 (11 to 310)\n"
            "  Rate           100 Hz\n"
            "  Duration       3.00 s\n"
            "  Unit           mm\n"
            "  Axes           to the right +X, up +Z\n"
            "  Analog         none\n"
            "  Stored as      C3D, DEC (VAX), integers in steps of 0.1 mm\n"
            "  Missing        3.9 % of all marker positions\n"
            "\nEvents\n"
            "  0.510 s  Smile  General  S\n"
            "\nGaps\n"
            "  Marker  Kind    Missing  Gaps  Longest\n"
            "  S:C     marker   11.7 %     2   0.25 s\n"
            "  3 points have no gap.\n");
}

TEST(C3dSummary, JsonHasTheDocumentedFields) {
  C3dLayout layout;
  const nlohmann::json json =
      nlohmann::json::parse(summary_json(summarise(healthy_take(), &layout)));
  for (const char* key : {"points", "frames", "first_frame", "rate_hz", "unit", "processor",
                          "storage", "analog_channels", "analog_rate_hz", "events", "markers"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["processor"], "intel");
  EXPECT_EQ(json["storage"], "float");
  EXPECT_EQ(json["points"], 4);
  for (const char* key : {"label", "subject", "kind", "valid_frames", "gaps", "longest_gap_s"}) {
    EXPECT_TRUE(json["markers"][0].contains(key)) << key;
  }
  const nlohmann::json table =
      nlohmann::json::parse(summary_json(summarise(healthy_take(), nullptr, "TRC")));
  EXPECT_TRUE(table["processor"].is_null());
  EXPECT_EQ(table["format"], "TRC");
}

}  // namespace
}  // namespace kinemesh::c3d_lint_test
