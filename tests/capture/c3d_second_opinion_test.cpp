#include "capture/c3d/second_opinion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "capture/c3d/ezc3d_process.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/writer.h"
#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/c3d_parts.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::c3d_second_opinion_test {
namespace {

MarkerSequence take_with_everything() {
  MarkerSequence take = test::make_take(20, 5);
  test::add_analog(take, 2, 3);
  take.events = {{"Foot Strike", "Left", "S", 0.125}};
  return take;
}

/// Our reading, and what a reader that is never wrong says, changed by `spoil`.
C3dCheckResult compared(const std::function<void(MarkerSequence&, Ezc3dHead&)>& spoil,
                        const MarkerSequence& take = take_with_everything()) {
  const C3dReadResult own = test::read_encoded(encode_c3d(take));
  MarkerSequence other = own.take;
  Ezc3dHead head{.parameters = own.take.parameters,
                 .header_events = own.header.events,
                 .first_frame = own.take.first_frame,
                 .rate_hz = own.take.rate_hz};
  spoil(other, head);
  C3dCheckResult result;
  compare_readers(own, other, head, result);
  return result;
}

/// The finding of this code whose place or message holds `text`.
bool names(const C3dCheckResult& result, std::string_view code, std::string_view text) {
  return std::ranges::any_of(result.findings, [&](const C3dFinding& f) {
    return f.code == code && (f.place + " " + f.message).find(text) != std::string::npos;
  });
}

TEST(SecondOpinion, NothingDiffers) {
  const C3dCheckResult result = compared([](MarkerSequence&, Ezc3dHead&) {});
  EXPECT_EQ(result.second_opinion, SecondOpinion::agrees);
  EXPECT_TRUE(result.findings.empty());
}

TEST(SecondOpinion, UnexplainedDifferencesOfEveryKindAreNamed) {
  struct Case {
    const char* text;
    std::function<void(MarkerSequence&, Ezc3dHead&)> spoil;
  };
  const std::vector<Case> cases = {
      {"marker M3", [](auto& take, auto&) { take.position(5, 2)[0] += 5.0F; }},
      {"measured only", [](auto& take, auto&) { take.flags()[0] ^= SampleFlag::valid; }},
      {"marker M2",
       [](auto&, auto& head) {
         head.parameters.set("POINT", texts_parameter("LABELS", {"M1", "X", "M3", "M4", "M5"}));
       }},
      {"parameter POINT:LABELS",
       [](auto&, auto& head) {
         head.parameters.set("POINT", texts_parameter("LABELS", {"M1", "X", "M3", "M4", "M5"}));
       }},
      {"event Foot Strike",
       [](auto&, auto& head) {
         head.parameters.set("EVENT", real_parameter("TIMES", {0, 0.5}, {2, 1}));
       }},
      {"analog channel", [](auto& take, auto&) { take.analog.values[7] += 3.0F; }},
      {"parameter POINT:UNITS",
       [](auto&, auto& head) { head.parameters.set("POINT", text_parameter("UNITS", "cm")); }},
      {"Hz in B", [](auto&, auto& head) { head.rate_hz = 99.0; }},
      {"first frame", [](auto&, auto& head) { head.first_frame = 2; }},
      {"it is only in A",
       [](auto&, auto& head) { test::erase_parameter(head.parameters, "EVENT", "CONTEXTS"); }},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.text);
    const C3dCheckResult result = compared(c.spoil);
    EXPECT_EQ(result.second_opinion, SecondOpinion::differs);
    EXPECT_TRUE(names(result, "C3D803", c.text)) << check_text(result);
  }
}

TEST(SecondOpinion, KnownFaultsOfEzc3dAreNamedAsSuch) {
  struct Case {
    const char* text;
    std::function<void(MarkerSequence&, Ezc3dHead&)> spoil;
  };
  const std::vector<Case> cases = {
      {"exchanges residual", [](auto& take, auto&) { take.residuals()[1] += 2.0F; }},
      {"exchanges residual", [](auto& take, auto&) { take.camera_masks()[1] ^= 3; }},
      {"POINT:EXTRA",
       [](auto&, auto& head) { head.parameters.set("POINT", real_parameter("EXTRA", {0.0})); }},
      {"key 12345",
       [](auto&, auto& head) { head.header_events.push_back({.label = "XX", .time_s = 0.1}); }},
      {"replaces it",
       [](auto&, auto& head) { head.parameters.find("POINT", "FRAMES")->numbers = {21}; }},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.text);
    const C3dCheckResult result = compared(c.spoil);
    EXPECT_EQ(result.second_opinion, SecondOpinion::agrees) << check_text(result);
    EXPECT_TRUE(names(result, "C3D802", c.text)) << check_text(result);
  }
}

TEST(SecondOpinion, WhatMeansTheSameIsNoDifference) {
  const C3dCheckResult result = compared([](MarkerSequence&, Ezc3dHead& head) {
    C3dParameter& labels = *head.parameters.find("POINT", "LABELS");
    labels = texts_parameter("LABELS", {"M1  ", "M2", "M3", "M4", std::string("M5\0", 3)});
    head.parameters.find("POINT", "USED")->dimensions = {1};
  });
  EXPECT_EQ(result.second_opinion, SecondOpinion::agrees);
  EXPECT_TRUE(result.findings.empty()) << check_text(result);
}

C3dCheckResult check_bytes(const std::string& bytes) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "take.c3d", bytes);
  return check_session(folder.path() / "take.c3d");
}

TEST(SecondOpinion, SignsOfAnalogOffsets) {
  test::C3dParts parts = test::take_apart(encode_c3d(take_with_everything(), {.storage = "int"}));
  parts.parameters.set("ANALOG", integer_parameter("OFFSET", {-30, -30}, {2}));
  parts.parameters.set("ANALOG", text_parameter("FORMAT", "SIGNED"));
  const C3dCheckResult result = check_bytes(test::put_together(parts));
  EXPECT_EQ(result.second_opinion, SecondOpinion::agrees) << check_text(result);
  EXPECT_TRUE(names(result, "C3D802", "drops the sign of ANALOG:OFFSET")) << check_text(result);
}

TEST(SecondOpinion, FirstFramesThatOnlyTrialHolds) {
  MarkerSequence take = take_with_everything();
  take.first_frame = 70'000;
  const C3dCheckResult result = check_bytes(encode_c3d(take));
  EXPECT_EQ(result.second_opinion, SecondOpinion::agrees) << check_text(result);
  EXPECT_TRUE(names(result, "C3D802", "ignores TRIAL:ACTUAL_START_FIELD")) << check_text(result);
}

TEST(SecondOpinion, WhyEzc3dRefusesIsSaidWhereItIsKnown) {
  MarkerSequence take = take_with_everything();
  C3dParameter described = text_parameter("NOTE", "x");
  described.description = std::string(200, 'd');
  take.parameters.set("MINE", described);
  const C3dCheckResult longer = check_bytes(encode_c3d(take));
  EXPECT_EQ(longer.second_opinion, SecondOpinion::refused);
  EXPECT_TRUE(names(longer, "C3D804", "ezc3d is wrong")) << check_text(longer);
  test::C3dParts parts = test::take_apart(encode_c3d(take_with_everything()));
  parts.parameters.set("POINT", real_parameter("FRAMES", {20}));
  const C3dCheckResult real = check_bytes(test::put_together(parts));
  EXPECT_TRUE(names(real, "C3D804", "POINT:FRAMES to be an integer")) << check_text(real);
}

TEST(SecondOpinion, TheReaderEzc3dRunsApartToo) {
  const test::TemporaryFolder folder;
  MarkerSequence take = take_with_everything();
  const auto path = folder.path() / "take.c3d";
  write_file(path, encode_c3d(take));
  const C3dReadResult own = read_c3d(path);
  const C3dReadResult other = read_c3d(path, {.reader = C3dReader::ezc3d});
  EXPECT_TRUE(std::ranges::equal(own.take.flags(), other.take.flags()));
  EXPECT_TRUE(std::ranges::equal(own.take.analog.values, other.take.analog.values));
  EXPECT_TRUE(std::ranges::all_of(other.take.residuals(), [](float r) { return r == 0.0F; }));
  // What makes ezc3d crash or run out of memory is an error, not the end of the program.
  C3dParameter described = text_parameter("NOTE", "x");
  described.description = std::string(200, 'd');
  take.parameters.set("MINE", described);
  take.parameters.set("MINE", {.name = "NONE", .type = C3dType::text, .dimensions = {0, 5}});
  write_file(path, encode_c3d(take));
  EXPECT_THROW(read_c3d(path, {.reader = C3dReader::ezc3d}), InputError);
}

}  // namespace
}  // namespace kinemesh::c3d_second_opinion_test
