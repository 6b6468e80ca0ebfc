#include "capture/c3d/check.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "capture/c3d/ezc3d_process.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/second_opinion.h"
#include "capture/c3d/writer.h"
#include "config/output_file.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::c3d_check_test {
namespace {

bool has(const C3dCheckResult& result, std::string_view code) {
  return std::ranges::any_of(result.findings, [&](const C3dFinding& f) { return f.code == code; });
}

C3dCheckResult check_bytes(const std::string& bytes, const C3dCheckOptions& options = {}) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "take.c3d", bytes);
  return check_session(folder.path() / "take.c3d", options);
}

/// What a reader that is never wrong says beside the samples.
Ezc3dHead same_head(const C3dReadResult& own) {
  return {.parameters = own.take.parameters,
          .header_events = own.header.events,
          .first_frame = own.take.first_frame,
          .rate_hz = own.take.rate_hz};
}

TEST(C3dCheck, C3D001UnreadableFilesAreFindings) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "empty.c3d", "");
  const C3dCheckResult empty = check_session(folder.path() / "empty.c3d");
  EXPECT_FALSE(empty.readable);
  EXPECT_TRUE(empty.has_errors());
  EXPECT_TRUE(has(empty, "C3D001"));
  ASSERT_EQ(::mkfifo((folder.path() / "fifo.c3d").c_str(), 0600), 0);
  for (const std::string& path :
       {folder.path().string(), (folder.path() / "fifo.c3d").string(), std::string("/dev/null"),
        (folder.path() / "missing.c3d").string()}) {
    const C3dCheckResult result = check_session(path);
    EXPECT_TRUE(has(result, "C3D001")) << path;
    EXPECT_TRUE(result.has_errors());
  }
}

TEST(C3dCheck, C3D801UnsupportedDialectsAreNotAsked) {
  const C3dCheckResult result =
      check_bytes(encode_c3d(test::make_take(20, 5), {.processor = "sgi"}));
  EXPECT_TRUE(has(result, "C3D801"));
  EXPECT_EQ(result.second_opinion, SecondOpinion::not_asked);
  EXPECT_FALSE(result.has_errors());
}

TEST(C3dCheck, C3D802KnownFaultsOfEzc3dAreNamed) {
  // make_take() has residuals and camera masks, which ezc3d exchanges.
  const C3dCheckResult result = check_bytes(encode_c3d(test::make_take(20, 5)));
  ASSERT_TRUE(has(result, "C3D802"));
  EXPECT_EQ(result.second_opinion, SecondOpinion::agrees);
  EXPECT_TRUE(std::ranges::any_of(result.findings, [](const C3dFinding& f) {
    return f.code == "C3D802" && f.message.find(
                                     "ezc3d is wrong: ezc3d exchanges residual and "
                                     "camera mask") != std::string::npos;
  }));
  const C3dCheckResult without =
      check_bytes(encode_c3d(test::make_take(20, 5)), {.second_opinion = false});
  EXPECT_FALSE(has(without, "C3D802"));
}

TEST(C3dCheck, C3D803UnexplainedDifferencesAreWarnings) {
  const std::string bytes = encode_c3d(test::make_take(20, 5));
  const C3dReadResult own = read_c3d(std::as_bytes(std::span(bytes)), "own");
  MarkerSequence other = own.take;
  other.position(5, 2)[0] += 5.0F;
  other.position(4, 3)[0] += 2.0F;
  Ezc3dHead head = same_head(own);
  C3dCheckResult result;
  compare_readers(own, other, head, result);
  EXPECT_EQ(result.second_opinion, SecondOpinion::differs);
  ASSERT_EQ(result.findings.size(), 1U);
  EXPECT_EQ(result.findings[0].code, "C3D803");
  EXPECT_EQ(result.findings[0].place, "marker M3");
  EXPECT_EQ(
      result.findings[0].message,
      "with Kinemesh as A and ezc3d as B, it lies up to 5 mm apart (frame 6), in 1 of 20 frames; "
      "likewise marker M4");
}

TEST(C3dCheck, C3D804SoundFilesThatEzc3dRefuses) {
  std::string bytes = encode_c3d(test::make_take(20, 5));
  bytes[1] = 81;  // the key: only a warning to us
  const C3dCheckResult result = check_bytes(bytes);
  EXPECT_FALSE(result.has_errors());
  EXPECT_TRUE(has(result, "C3D804")) << check_text(result);
  EXPECT_EQ(result.second_opinion, SecondOpinion::refused);
}

TEST(C3dCheck, DamagedFilesAreNotGivenToEzc3d) {
  const std::string bytes = encode_c3d(test::make_take(20, 5));
  const C3dCheckResult result = check_bytes(bytes.substr(0, bytes.size() - 700));
  EXPECT_TRUE(has(result, "C3D302"));
  EXPECT_TRUE(has(result, "C3D801"));
}

TEST(C3dCheck, WhatEzc3dDoesToDamagedFilesStaysInItsProcess) {
  KINEMESH_NEED_DATA("c3d_conformance/others/mocap36.c3d");
  for (const char* file : {"sample_18/bad_parameter_section.c3d", "others/mocap36.c3d"}) {
    const auto path = test::data_folder() / "c3d_conformance" / file;
    C3dReadResult result = read_c3d(path);
    result.findings.clear();  // as if it were sound
    const std::vector<float> before(result.take.positions().begin(), result.take.positions().end());
    Ezc3dHead head;
    EXPECT_FALSE(read_with_ezc3d_apart(path, {}, result, head).empty()) << file;
    EXPECT_TRUE(std::equal(before.begin(), before.end(), result.take.positions().begin(),
                           [](float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }));
  }
}

TEST(C3dCheck, TablesAreLintedToo) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "t.csv",
             "# kinemesh points csv 1\n# rate_hz,1\nframe,time_s,A.x,A.y,A.z,B.x,B.y,B.z\n"
             "1,0,1,2,3,,,\n2,1,1,2,4,,,\n");
  const C3dCheckResult result = check_session(folder.path() / "t.csv");
  EXPECT_TRUE(result.readable);
  EXPECT_TRUE(has(result, "C3D701"));
  EXPECT_TRUE(has(result, "C3D704"));
}

TEST(C3dCheck, TextAndJson) {
  C3dCheckResult result{.file = "a.c3d", .readable = true};
  EXPECT_EQ(check_text(result), "a.c3d: healthy\n");
  result.findings = {c3d_finding("C3D302", "40 frames are declared, 39 are complete", "frame 40"),
                     c3d_finding("C3D703", "all residuals are 0", "")};
  EXPECT_EQ(check_text(result),
            "a.c3d: 1 error, 1 note\n"
            "  error    C3D302  frame 40: 40 frames are declared, 39 are complete\n"
            "           Copy the file again from its source; otherwise --repair keeps the complete "
            "frames\n"
            "  note     C3D703  all residuals are 0\n");
  const nlohmann::json json = nlohmann::json::parse(check_json({result}));
  EXPECT_TRUE(json["errors"]);
  EXPECT_EQ(json["files"][0]["findings"][0]["code"], "C3D302");
  EXPECT_EQ(json["files"][0]["findings"][0]["place"], "frame 40");
  EXPECT_EQ(json["files"][0]["second_opinion"], "not_asked");
}

TEST(C3dCheck, HealthyRealFilesAgreeWithEzc3d) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_01/Eb015vr.c3d");
  for (const char* file : {"sample_01/Eb015pi.c3d", "sample_01/Eb015pr.c3d",
                           "sample_01/Eb015vi.c3d", "sample_01/Eb015vr.c3d", "sample_10/TYPE-3.c3d",
                           "others/labels2_task.c3d", "others/duplicate_labels.c3d"}) {
    const C3dCheckResult result = check_session(test::data_folder() / "c3d_conformance" / file);
    EXPECT_EQ(result.second_opinion, SecondOpinion::agrees) << check_text(result);
    EXPECT_FALSE(result.has_errors());
  }
}

}  // namespace
}  // namespace kinemesh::c3d_check_test
