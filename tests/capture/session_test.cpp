#include "capture/session.h"

#include <gtest/gtest.h>

#include "capture/c3d/writer.h"
#include "capture/formats/session_export.h"
#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::session_test {
namespace {

TEST(Session, FormatsAreKnownByContentBeforeTheExtension) {
  const test::TemporaryFolder folder;
  const MarkerSequence take = test::make_take(5, 3);
  const auto with = [&folder](const std::string& name, const std::string& content) {
    write_file(folder.path() / name, content);
    return detect_session_format(folder.path() / name);
  };
  EXPECT_EQ(with("a.c3d", encode_c3d(take)), SessionFormat::c3d);
  EXPECT_EQ(with("a.dat", encode_c3d(take)), SessionFormat::c3d);
  EXPECT_EQ(with("b.dat", std::string(3, '\0') + encode_c3d(take)), SessionFormat::c3d);
  EXPECT_EQ(with("empty.c3d", ""), SessionFormat::c3d);  // refused by its reader, with the reason
  EXPECT_EQ(with("a.txt", "PathFileType\t4\n"), SessionFormat::trc);
  EXPECT_EQ(with("a.csv", "Format Version,1.23,Take Name,x\n"), SessionFormat::motive);
  EXPECT_EQ(with("a.tsv", "NO_OF_FRAMES\t3\n"), SessionFormat::qtm);
  EXPECT_EQ(with("b.csv", "\xEF\xBB\xBF# kinemesh points csv 1\n"), SessionFormat::csv);
  EXPECT_EQ(with("c.csv", "frame,time_s,A.x\n"), SessionFormat::csv);
  EXPECT_THROW(with("d.csv", "name,price\n"), InputError);
  EXPECT_THROW(with("e.png", "\x89PNG\r\n"), InputError);
  EXPECT_THROW(detect_session_format(folder.path()), InputError);
  EXPECT_THROW(detect_session_format("/dev/null"), InputError);
}

TEST(Session, APictureIsNoC3dWhateverItsSecondByteAndName) {
  const test::TemporaryFolder folder;
  for (const char* name : {"face.png", "face.c3d"}) {
    write_file(folder.path() / name, "\x89PNG\r\n\x1A\n" + std::string(4000, '\x02'));
    try {
      read_session(folder.path() / name);
      FAIL() << name << " was read";
    } catch (const InputError& e) {
      EXPECT_EQ(e.details().what, "this is a picture (PNG), no session");
    }
  }
}

TEST(Session, AC3dAndItsExportsAreTheSameSession) {
  const test::TemporaryFolder folder;
  const MarkerSequence take = test::make_take(30, 6);
  write_c3d(take, folder.path() / "a.c3d");
  const MarkerSequence original = read_session(folder.path() / "a.c3d");
  for (const char* name : {"a.csv", "a.trc"}) {
    export_session(original, folder.path() / name);
    const MarkerSequence back = read_session(folder.path() / name);
    EXPECT_EQ(back.markers(), original.markers());
    EXPECT_EQ(back.rate_hz, original.rate_hz);
    EXPECT_EQ(validity_codes(back), validity_codes(original));
    EXPECT_EQ(back.origin.path, (folder.path() / name).string());
    for (std::size_t i = 0; i < original.sample_count(); ++i) {
      if ((original.flags()[i] & SampleFlag::valid) == 0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(back.positions()[3 * i + k], original.positions()[3 * i + k]);
      }
    }
  }
}

TEST(Session, FindingsOfAC3dBecomeWarnings) {
  const test::TemporaryFolder folder;
  const std::string bytes = encode_c3d(test::make_take(30, 6));
  write_file(folder.path() / "cut.c3d", bytes.substr(0, bytes.size() - 600));
  std::vector<std::string> warnings;
  RunContext ctx;
  ctx.set_log([&warnings](LogLevel, std::string_view text) { warnings.emplace_back(text); });
  const SessionSummaryResult result = summarise_session(folder.path() / "cut.c3d", {}, ctx);
  EXPECT_LT(result.summary.frames, 30U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("cut.c3d: C3D302: frame "), std::string::npos) << warnings[0];
}

TEST(Session, EveryRealFileIsExportedAndReadBackAlike) {
  KINEMESH_NEED_DATA("c3d_conformance/others/labels2_task.c3d");
  const test::TemporaryFolder folder;
  for (const char* file :
       {"c3d_conformance/others/labels2_task.c3d", "c3d_face/AnimFace-Eyebrows.c3d",
        "c3d_conformance/others/duplicate_labels.c3d"}) {
    SCOPED_TRACE(file);
    const MarkerSequence take = read_session(test::data_folder() / file);
    export_session(take, folder.path() / "a.csv");
    const MarkerSequence back = read_session(folder.path() / "a.csv");
    ASSERT_EQ(back.markers().size(), take.markers().size());
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      EXPECT_EQ(back.markers()[m].label, take.markers()[m].label);
      EXPECT_EQ(back.markers()[m].subject, take.markers()[m].subject);
      EXPECT_EQ(back.markers()[m].kind, take.markers()[m].kind);
      EXPECT_EQ(back.markers()[m].unit, take.markers()[m].unit);
    }
    EXPECT_EQ(validity_codes(back), validity_codes(take));
    EXPECT_EQ(back.events, take.events);
    EXPECT_EQ(back.first_frame, take.first_frame);
  }
}

}  // namespace
}  // namespace kinemesh::session_test
