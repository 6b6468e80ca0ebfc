// The real files of c3d_conformance and c3d_face: what is known of them must come out.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numeric>

#include "capture/c3d/ezc3d_reader.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/reader.h"
#include "config/error.h"
#include "config/text.h"
#include "tests/support/data.h"

namespace kinemesh::c3d_real_files_test {
namespace {

std::vector<std::filesystem::path> c3d_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (lower(entry.path().extension().string()) == ".c3d") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

std::size_t valid_samples(const MarkerSequence& take) {
  return static_cast<std::size_t>(
      std::ranges::count_if(take.flags(), [](uint8_t f) { return (f & SampleFlag::valid) != 0; }));
}

bool has(const C3dReadResult& r, std::string_view code) {
  return std::ranges::any_of(r.findings, [&](const C3dFinding& f) { return f.code == code; });
}

TEST(C3dRealFiles, AllOfTheConformanceSetIsReadOrRefusedWithItsReason) {
  KINEMESH_NEED_DATA("c3d_conformance");
  std::size_t read = 0;
  for (const auto& path : c3d_files(test::data_folder() / "c3d_conformance")) {
    SCOPED_TRACE(path.string());
    if (path.filename() == "Empty.c3d") {
      try {
        read_c3d(path);
        FAIL() << "an empty file was read";
      } catch (const InputError& e) {
        EXPECT_EQ(e.details().what, "the file is empty");
      }
      continue;
    }
    const C3dReadResult r = read_c3d(path);
    EXPECT_GT(r.take.frame_count(), 0U);
    EXPECT_GT(r.take.marker_count(), 0U);
    EXPECT_EQ(r.layout.frames, r.layout.declared_frames);
    ++read;
  }
  EXPECT_EQ(read, 33U);
}

/// The six variants of one take agree within what integer storage keeps.
void expect_variants_agree(const std::filesystem::path& folder,
                           const std::vector<std::string>& names, const std::string& exempt_masks) {
  const C3dReadResult first = read_c3d(folder / names[0]);
  // The files were converted by truncation, so integers may be one step off.
  const float step_mm = static_cast<float>(std::abs(first.layout.scale));
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const C3dReadResult other = read_c3d(folder / name);
    const MarkerSequence& a = first.take;
    const MarkerSequence& b = other.take;
    ASSERT_EQ(a.sample_count(), b.sample_count());
    EXPECT_EQ(a.markers(), b.markers());
    EXPECT_EQ(a.rate_hz, b.rate_hz);
    EXPECT_EQ(a.first_frame, b.first_frame);
    EXPECT_EQ(a.analog.channels, b.analog.channels);
    ASSERT_EQ(a.analog.values.size(), b.analog.values.size());
    for (std::size_t i = 0; i < a.sample_count(); ++i) {
      ASSERT_EQ(a.flags()[i], b.flags()[i]) << i;
      if (a.flags()[i] == 0) continue;
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_NEAR(a.positions()[3 * i + k], b.positions()[3 * i + k], step_mm * 1.001F);
      ASSERT_NEAR(a.residuals()[i], b.residuals()[i], 1e-5F);
      const bool same_mask = a.camera_masks()[i] == b.camera_masks()[i];
      ASSERT_TRUE(same_mask || name == exempt_masks) << i;
    }
    for (std::size_t i = 0; i < a.analog.values.size(); ++i) {
      const float step = std::abs(a.analog.values[i]) * 1e-6F + 1e-4F;
      ASSERT_NEAR(a.analog.values[i], b.analog.values[i], step) << i;
    }
  }
}

TEST(C3dRealFiles, TheSixVariantsOfSample01Agree) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_01/Eb015pi.c3d");
  expect_variants_agree(
      test::data_folder() / "c3d_conformance/sample_01",
      {"Eb015pr.c3d", "Eb015pi.c3d", "Eb015si.c3d", "Eb015sr.c3d", "Eb015vi.c3d", "Eb015vr.c3d"},
      "");
}

TEST(C3dRealFiles, TheSixVariantsOfSample02Agree) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_02/pc_int.c3d");
  expect_variants_agree(
      test::data_folder() / "c3d_conformance/sample_02",
      {"pc_real.c3d", "pc_int.c3d", "dec_int.c3d", "dec_real.c3d", "sgi_int.c3d", "sgi_real.c3d"},
      "dec_int.c3d");
}

TEST(C3dRealFiles, Sample01HasItsKnownFirstPoint) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_01/Eb015pr.c3d");
  for (const char* name : {"Eb015pr.c3d", "Eb015vi.c3d", "Eb015sr.c3d"}) {
    const C3dReadResult r = read_c3d(test::data_folder() / "c3d_conformance/sample_01" / name);
    EXPECT_NEAR(r.take.residuals()[0], 1.3333F, 5e-5F);
    EXPECT_EQ(r.take.camera_masks()[0], 0b0111110);
    EXPECT_EQ(r.take.markers()[0].label, "RFT1");
    ASSERT_EQ(r.take.events.size(), 3U);
    EXPECT_EQ(r.take.events[0].label, "RIC");
  }
}

TEST(C3dRealFiles, PointersOfTheHeaderAreFollowed) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_08/EB015PI.c3d");
  const auto folder = test::data_folder() / "c3d_conformance/sample_08";
  const C3dReadResult truth = read_c3d(folder / "EB015PI.c3d");
  for (const char* name : {"TESTAPI.c3d", "TESTBPI.c3d", "TESTCPI.c3d", "TESTDPI.c3d"}) {
    const C3dReadResult r = read_c3d(folder / name);
    EXPECT_TRUE(std::ranges::equal(r.take.positions(), truth.take.positions())) << name;
    EXPECT_TRUE(std::ranges::equal(r.take.camera_masks(), truth.take.camera_masks())) << name;
  }
}

TEST(C3dRealFiles, FacialSingIsReadThoughItsRecordsLackAByte) {
  KINEMESH_NEED_DATA("c3d_face/Facial-Sing.c3d");
  const C3dReadResult r = read_c3d(test::data_folder() / "c3d_face/Facial-Sing.c3d");
  EXPECT_EQ(r.take.frame_count(), 3000U);
  EXPECT_EQ(r.take.marker_count(), 38U);
  EXPECT_EQ(r.take.rate_hz, 100.0);
  EXPECT_NEAR(
      static_cast<double>(valid_samples(r.take)) / static_cast<double>(r.take.sample_count()),
      0.967, 5e-4);
  EXPECT_EQ(std::ranges::count(r.take.markers(), MarkerKind::unlabelled, &Marker::kind), 1);
  EXPECT_TRUE(has(r, "C3D207"));
}

TEST(C3dRealFiles, Mocap36HasAllItsFrames) {
  KINEMESH_NEED_DATA("c3d_conformance/others/mocap36.c3d");
  const C3dReadResult r = read_c3d(test::data_folder() / "c3d_conformance/others/mocap36.c3d");
  EXPECT_EQ(r.take.frame_count(), 1380U);
  EXPECT_EQ(r.take.markers()[0].label, "Skeleton_Hip2");
  EXPECT_TRUE(has(r, "C3D207"));
}

TEST(C3dRealFiles, LabelsContinueInLabels2) {
  KINEMESH_NEED_DATA("c3d_conformance/others/labels2_task.c3d");
  const C3dReadResult r = read_c3d(test::data_folder() / "c3d_conformance/others/labels2_task.c3d");
  ASSERT_EQ(r.take.marker_count(), 332U);
  EXPECT_EQ(r.take.markers()[255].label, "LCLAVICLE_Z");
  EXPECT_EQ(r.take.first_frame, 153);
  EXPECT_EQ(r.take.events.size(), 16U);
  EXPECT_EQ(r.take.events[0].label, "Foot Strike");
  EXPECT_EQ(r.take.events[0].context, "Left");
  EXPECT_NEAR(r.take.events[0].time_s, 2.61, 1e-6);
  EXPECT_EQ(std::ranges::count(r.take.markers(), MarkerKind::angle, &Marker::kind), 50);
  const std::size_t moment = r.take.find("LViconAnkleMoment");
  ASSERT_NE(moment, MarkerSequence::npos);
  EXPECT_EQ(r.take.markers()[moment].kind, MarkerKind::moment);
  EXPECT_EQ(r.take.markers()[moment].unit, "Nmm");
}

TEST(C3dRealFiles, PrefixesNameTheSubject) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_04/sub_labels.c3d");
  const C3dReadResult r =
      read_c3d(test::data_folder() / "c3d_conformance/sample_04/sub_labels.c3d");
  EXPECT_EQ(r.take.markers()[0].label, "C7");
  EXPECT_EQ(r.take.markers()[0].subject, "Matt");
  EXPECT_EQ(r.take.find("Matt:C7"), 0U);
}

TEST(C3dRealFiles, MetresBecomeMillimetresAndNaNsBecomeGaps) {
  KINEMESH_NEED_DATA("c3d_conformance/others/kinematics_tennis_serve_nan.c3d");
  const C3dReadResult r =
      read_c3d(test::data_folder() / "c3d_conformance/others/kinematics_tennis_serve_nan.c3d");
  EXPECT_EQ(r.take.origin.unit, "m");
  EXPECT_NEAR(r.take.positions()[2], 1426.07F, 0.01F);
  EXPECT_TRUE(has(r, "C3D408"));
  for (std::size_t i = 0; i < r.take.sample_count(); ++i) {
    ASSERT_TRUE(r.take.flags()[i] == 0 || std::isfinite(r.take.positions()[3 * i]));
  }
}

TEST(C3dRealFiles, UnsignedOffsetsAndUnsignedMinusOnesAreUnderstood) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_07/16bitanalog.c3d");
  const C3dReadResult r =
      read_c3d(test::data_folder() / "c3d_conformance/sample_07/16bitanalog.c3d");
  EXPECT_EQ(valid_samples(r.take), 0U);
  EXPECT_TRUE(has(r, "C3D409"));
  // 32789 with an offset of 32767 and a scale of -0.01158.
  EXPECT_NEAR(r.take.analog.values[0], -0.25476F, 1e-5F);
  KINEMESH_NEED_DATA("c3d_conformance/others/parameterOverflow.c3d");
  const C3dReadResult overflow =
      read_c3d(test::data_folder() / "c3d_conformance/others/parameterOverflow.c3d");
  EXPECT_TRUE(has(overflow, "C3D503"));
  EXPECT_TRUE(has(overflow, "C3D201"));
  EXPECT_LT(std::abs(overflow.take.analog.values[0]), 100.0F);
}

TEST(C3dRealFiles, AFileWithoutParametersIsReadByItsHeader) {
  KINEMESH_NEED_DATA("c3d_conformance/sample_20/phasespace_sample.c3d");
  const C3dReadResult r =
      read_c3d(test::data_folder() / "c3d_conformance/sample_20/phasespace_sample.c3d");
  EXPECT_EQ(r.take.frame_count(), 701U);
  EXPECT_EQ(r.take.marker_count(), 40U);
  EXPECT_EQ(r.take.rate_hz, 30.0);
  EXPECT_TRUE(has(r, "C3D104"));
}

TEST(C3dRealFiles, HeadAndWholeFileAgree) {
  KINEMESH_NEED_DATA("c3d_conformance");
  for (const auto& path : c3d_files(test::data_folder() / "c3d_conformance")) {
    if (path.filename() == "Empty.c3d") continue;
    const C3dReadResult whole = read_c3d(path);
    const C3dHeadResult head = read_c3d_head(path);
    EXPECT_EQ(head.take.frame_count(), 0U);
    EXPECT_EQ(head.layout.frames, whole.layout.frames);
    EXPECT_EQ(head.take.markers(), whole.take.markers());
    EXPECT_EQ(head.take.parameters, whole.take.parameters);
    EXPECT_EQ(head.take.events, whole.take.events);
    EXPECT_EQ(head.header, whole.header);
  }
}

/// Where ezc3d supports the dialect both readers find the same values.
TEST(C3dRealFiles, Ezc3dAgreesWhereItSupportsTheFile) {
  KINEMESH_NEED_DATA("c3d_conformance");
  std::size_t compared = 0;
  for (const auto& path : c3d_files(test::data_folder() / "c3d_conformance")) {
    if (path.filename() == "Empty.c3d") continue;
    SCOPED_TRACE(path.string());
    const C3dReadResult own = read_c3d(path);
    if (!ezc3d_refusal(own).empty()) {
      EXPECT_THROW(read_c3d(path, {.reader = C3dReader::ezc3d}), InputError);
      continue;
    }
    const C3dReadResult other = read_c3d(path, {.reader = C3dReader::ezc3d});
    ASSERT_EQ(own.take.sample_count(), other.take.sample_count());
    for (std::size_t i = 0; i < own.take.sample_count(); ++i) {
      ASSERT_EQ(own.take.flags()[i], other.take.flags()[i]) << i;
      if (own.take.flags()[i] == 0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const float value = own.take.positions()[3 * i + k];
        ASSERT_NEAR(value, other.take.positions()[3 * i + k], 1e-3F + 1e-6F * std::abs(value));
      }
    }
    ASSERT_EQ(own.take.analog.values.size(), other.take.analog.values.size());
    for (std::size_t i = 0; i < own.take.analog.values.size(); ++i) {
      const float value = own.take.analog.values[i];
      ASSERT_NEAR(value, other.take.analog.values[i], 1e-3F + 1e-5F * std::abs(value)) << i;
    }
    ++compared;
  }
  EXPECT_GE(compared, 18U);
}

}  // namespace
}  // namespace kinemesh::c3d_real_files_test
