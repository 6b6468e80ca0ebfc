#include "capture/c3d/writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "capture/c3d/parameter_access.h"
#include "config/error.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"

namespace kinemesh::c3d_writer_test {
namespace {

using test::add_analog;
using test::expect_same_take;
using test::has_finding;
using test::make_take;
using test::read_encoded;

struct Variant {
  const char* processor;
  const char* storage;
};
constexpr Variant variants[] = {{"intel", "int"}, {"intel", "float"}, {"dec", "int"},
                                {"dec", "float"}, {"sgi", "int"},     {"sgi", "float"}};

C3dWriteOptions options_of(const Variant& v) {
  return {.processor = v.processor, .storage = v.storage};
}

bool no_warnings(const C3dReadResult& r) {
  return std::ranges::none_of(r.findings,
                              [](const C3dFinding& f) { return f.severity != Severity::info; });
}

/// A take with everything a file can hold.
MarkerSequence full_take() {
  MarkerSequence take = make_take(60, 12);
  add_analog(take, 3, 4);
  take.first_frame = 153;
  take.events = {{"Foot Strike", "Left", "Trève", 1.75},
                 {"Foot Off", "Right", "Trève", 1.5625},
                 {"Général", "General", "", 2.0}};
  take.markers()[0].label = "Großer Trochanter";
  take.markers()[1].description = std::string(255, 'd');
  take.markers()[3] = {.label = "LHipAngles", .kind = MarkerKind::angle, .unit = "deg"};
  take.markers()[4] = {.label = "*7", .kind = MarkerKind::unlabelled};
  take.origin.x_screen = "+X";
  take.origin.y_screen = "+Z";
  C3dParameter long_one = text_parameter("NOTE", "kept");
  long_one.description = std::string(255, 'x');
  take.parameters.set("FORCE_PLATFORM", integer_parameter("USED", {1.0}));
  take.parameters.set("FORCE_PLATFORM", integer_parameter("CHANNEL", {1, 2, 3, 4, 5, 6}, {6, 1}));
  take.parameters.set(
      "FORCE_PLATFORM",
      real_parameter("CORNERS", {1.5, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, {3, 4, 1}));
  take.parameters.set("MINE", long_one);
  take.parameters.set("MINE", {.name = "BYTES",
                               .locked = true,
                               .type = C3dType::byte,
                               .dimensions = {3},
                               .numbers = {0, 128, 255}});
  return take;
}

TEST(C3dWriter, EverythingSurvivesARoundTripInEveryVariant) {
  const MarkerSequence take = full_take();
  for (const Variant& v : variants) {
    SCOPED_TRACE(std::string(v.processor) + " " + v.storage);
    std::vector<C3dLoss> losses;
    const C3dReadResult r = read_encoded(encode_c3d(take, options_of(v), &losses));
    EXPECT_TRUE(no_warnings(r)) << r.findings.front().message;
    expect_same_take(take, r.take, 0.0F, 0.0F, 0.0F);
    for (const C3dGroup& group : take.parameters.groups) {
      for (const C3dParameter& p : group.parameters) {
        const C3dParameter* kept = r.take.parameters.find(group.name, p.name);
        ASSERT_NE(kept, nullptr) << p.name;
        EXPECT_EQ(*kept, p) << p.name;
      }
    }
    EXPECT_EQ(r.take.origin.x_screen, "+X");
    // Written once more, the file is the same byte for byte.
    const std::string again = encode_c3d(r.take);
    EXPECT_EQ(again, encode_c3d(read_encoded(again).take));
  }
}

TEST(C3dWriter, RealFilesSurviveARoundTripInEveryVariant) {
  KINEMESH_NEED_DATA("c3d_conformance");
  for (const char* name :
       {"sample_01/Eb015pr.c3d", "sample_02/sgi_int.c3d", "sample_04/sub_labels.c3d",
        "sample_07/16bitanalog.c3d", "others/labels2_task.c3d", "others/parameterOverflow.c3d",
        "others/kinematics_tennis_serve_nan.c3d", "sample_10/TYPE-3.c3d"}) {
    const C3dReadResult original = read_c3d(test::data_folder() / "c3d_conformance" / name);
    for (const Variant& v : variants) {
      SCOPED_TRACE(std::string(name) + " " + v.processor + " " + v.storage);
      const C3dReadResult r = read_encoded(encode_c3d(original.take, options_of(v)));
      EXPECT_FALSE(has_errors(r.findings));
      const bool integers = std::string(v.storage) == "int";
      const float factor = original.take.origin.unit == "m" ? 1000.0F : 1.0F;
      const float step = factor * static_cast<float>(std::abs(r.layout.scale));
      float analog = 0.0F;
      for (const float x : original.take.analog.values)
        analog = std::max(analog, integers ? std::abs(x) / 30'000.0F : 0.0F);
      expect_same_take(original.take, r.take, integers ? 0.501F * step : 0.0F,
                       integers ? 0.501F * step : 1e-6F, analog);
    }
  }
}

TEST(C3dWriter, UntouchedParametersOfRealFilesKeepEveryValue) {
  KINEMESH_NEED_DATA("c3d_conformance");
  for (const char* name : {"sample_01/Eb015vi.c3d", "sample_02/sgi_real.c3d",
                           "sample_04/sub_labels.c3d", "others/labels2_task.c3d"}) {
    SCOPED_TRACE(name);
    const C3dReadResult original = read_c3d(test::data_folder() / "c3d_conformance" / name);
    C3dParameters before = original.take.parameters;
    for (const char* processor : {"intel", "dec", "sgi"}) {
      C3dParameters after =
          read_encoded(encode_c3d(original.take, {.processor = processor})).take.parameters;
      // Where the data begin depends on the size of the section.
      before.find("POINT", "DATA_START")->numbers = after.find("POINT", "DATA_START")->numbers;
      EXPECT_EQ(before, after);
    }
  }
}

TEST(C3dWriter, MoreThan255LabelsContinueInLabels2) {
  const MarkerSequence take = make_take(3, 600);
  const C3dReadResult r = read_encoded(encode_c3d(take));
  EXPECT_TRUE(no_warnings(r));
  expect_same_take(take, r.take, 0.0F, 0.0F, 0.0F);
  EXPECT_NE(r.take.parameters.find("POINT", "LABELS3"), nullptr);
  // Fewer markers later: nothing of the longer list stays.
  const std::size_t few[] = {0, 5, 599};
  MarkerSequence fewer = r.take.select(few);
  fewer.parameters = r.take.parameters;
  const C3dReadResult s = read_encoded(encode_c3d(fewer));
  EXPECT_TRUE(no_warnings(s));
  EXPECT_EQ(s.take.markers()[2].label, "M600");
  EXPECT_EQ(s.take.parameters.find("POINT", "LABELS2"), nullptr);
}

TEST(C3dWriter, MoreThan65535FramesAndLateFirstFramesAreKept) {
  MarkerSequence take = make_take(70'000, 1);
  take.first_frame = 100'000;
  const C3dReadResult r = read_encoded(encode_c3d(take));
  EXPECT_TRUE(no_warnings(r)) << r.findings[0].message;
  EXPECT_EQ(r.header.last_frame, 65'535);
  EXPECT_EQ(r.take.parameters.find("POINT", "LONG_FRAMES")->numbers[0], 70'000.0);
  expect_same_take(take, r.take, 0.0F, 0.0F, 0.0F);
  MarkerSequence late = make_take(10, 2);
  late.first_frame = 65'530;
  const C3dReadResult s = read_encoded(encode_c3d(late));
  EXPECT_TRUE(no_warnings(s)) << s.findings[0].message;
  EXPECT_EQ(s.take.first_frame, 65'530);
  EXPECT_EQ(s.take.frame_count(), 10U);
}

TEST(C3dWriter, UnitsAreConvertedAndDecodeToTheSameFloats) {
  MarkerSequence take = make_take(50, 4);
  for (const char* unit : {"mm", "cm", "m"}) {
    const C3dReadResult r = read_encoded(encode_c3d(take, {.storage = "float", .unit = unit}));
    EXPECT_EQ(r.take.origin.unit, unit);
    expect_same_take(take, r.take, 1e-4F, 1e-6F, 0.0F);
    // What a metre file held comes back to the last bit.
    expect_same_take(r.take, read_encoded(encode_c3d(r.take)).take, 0.0F, 0.0F, 0.0F);
  }
}

TEST(C3dWriter, ForcePlatesAreWrittenInTheUnitOfThePoints) {
  MarkerSequence take = make_take(5, 2);
  take.parameters.set("FORCE_PLATFORM", real_parameter("CORNERS", {520, 0, 0}, {3, 1, 1}));
  const auto corner = [](const MarkerSequence& t) {
    return t.parameters.find("FORCE_PLATFORM", "CORNERS")->numbers[0];
  };
  EXPECT_NEAR(corner(read_encoded(encode_c3d(take, {.unit = "m"})).take), 0.52, 1e-6);
  EXPECT_EQ(corner(read_encoded(encode_c3d(take)).take), 520.0);
}

TEST(C3dWriter, LossesAreSaidBeforeWriting) {
  MarkerSequence take = make_take(5, 2);
  EXPECT_TRUE(c3d_losses(take).empty());
  take.position(0, 0) = Eigen::Vector3f(123456.789F, 0.25F, 0.5F);
  const auto losses = c3d_losses(take, {.storage = "int"});
  ASSERT_FALSE(losses.empty());
  EXPECT_NE(losses[0].message.find("rounded to steps of"), std::string::npos);
  const auto clipped = c3d_losses(take, {.storage = "int", .scale = 0.1});
  EXPECT_TRUE(std::ranges::any_of(
      clipped, [](const C3dLoss& l) { return l.message.find("clipped") != std::string::npos; }));
  take.camera_masks()[0] = 0x80;
  take.add_uncertainty();
  EXPECT_EQ(c3d_losses(take, {.storage = "float"}).size(), 2U);
}

TEST(C3dWriter, FilledSamplesAreMarkedAsInterpolated) {
  MarkerSequence take = make_take(4, 1);
  take.flags()[1] = SampleFlag::valid | SampleFlag::filled;
  take.residuals()[1] = 3.0F;
  const C3dReadResult r = read_encoded(encode_c3d(take));
  EXPECT_EQ(r.take.flags()[1], SampleFlag::valid);
  EXPECT_EQ(r.take.residuals()[1], 0.0F);
}

TEST(C3dWriter, PointsWithoutIdentityBecomeColumns) {
  MarkerSequence take = make_take(3, 1);
  take.unlabelled.offsets = {0, 2, 2, 3};
  take.unlabelled.positions = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  take.unlabelled.residuals = {0.0F, 0.5F, 1.0F};
  take.unlabelled.camera_masks = {1, 2, 3};
  const C3dReadResult r = read_encoded(encode_c3d(take));
  ASSERT_EQ(r.take.marker_count(), 3U);
  EXPECT_EQ(r.take.markers()[1].kind, MarkerKind::unlabelled);
  EXPECT_TRUE(r.take.valid(0, 1) && r.take.valid(0, 2) && r.take.valid(2, 1));
  EXPECT_FALSE(r.take.valid(1, 1) || r.take.valid(2, 2));
  EXPECT_EQ(r.take.position(2, 1), Eigen::Vector3f(7, 8, 9));
}

TEST(C3dWriter, EventsMayBeChangedAndKeepTheirAttributes) {
  MarkerSequence take = full_take();
  MarkerSequence once = read_encoded(encode_c3d(take)).take;
  once.parameters.set("EVENT", integer_parameter("ICON_IDS", {7, 8, 9}, {3}));
  once.events.erase(once.events.begin());
  once.events.push_back({"smile begins", "", "", 1.875});
  const C3dReadResult r = read_encoded(encode_c3d(once));
  EXPECT_EQ(r.take.events, once.events);
  EXPECT_EQ(r.take.parameters.find("EVENT", "ICON_IDS")->numbers, (std::vector<double>{8, 9, 0}));
  EXPECT_TRUE(no_warnings(r));
}

TEST(C3dWriter, ManyEventsNeedNoLimit) {
  MarkerSequence take = make_take(1000, 1);
  for (int e = 0; e < 600; ++e)
    take.events.push_back({"event " + std::to_string(e), "General", "", 0.015625 * e});
  const C3dReadResult r = read_encoded(encode_c3d(take));
  EXPECT_EQ(r.take.events, take.events);
}

TEST(C3dWriter, ImpossibleTakesAreRefused) {
  MarkerSequence take = make_take(2, 2);
  add_analog(take, 2, 2);
  take.analog.values = Buffer<float>(3, 0.0F);
  EXPECT_THROW(encode_c3d(take), UsageError);
  EXPECT_THROW(encode_c3d(make_take(1, 65'536)), UsageError);
  EXPECT_THROW(encode_c3d(make_take(1, 1), {.storage = "double"}), UsageError);
  EXPECT_THROW(write_c3d(make_take(1, 1), "/dev/null/at/all.c3d"), InputError);
}

TEST(C3dWriter, FilesAreTheSameAsTheBytesInMemory) {
  const MarkerSequence take = full_take();
  const auto path = std::filesystem::temp_directory_path() / "kinemesh_writer_test.c3d";
  const C3dWriteResult result = write_c3d(take, path);
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(bytes, encode_c3d(take));
  EXPECT_EQ(result.bytes, bytes.size());
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace kinemesh::c3d_writer_test
