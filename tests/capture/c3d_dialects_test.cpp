// Dialects that are legal or harmless, and must not be called errors.
#include <gtest/gtest.h>

#include "capture/c3d/parameter_access.h"
#include "capture/c3d/writer.h"
#include "tests/support/c3d_parts.h"
#include "tests/support/c3d_takes.h"

namespace kinemesh::c3d_dialects_test {
namespace {

using test::C3dParts;
using test::erase_parameter;
using test::has_finding;
using test::read_encoded;

C3dParts parts_of_take(std::size_t markers) {
  MarkerSequence take = test::make_take(20, markers);
  test::add_analog(take, 2, 5);
  take.events = {{"Foot Strike", "Left", "S", 65.5}};
  return test::take_apart(encode_c3d(take));
}

TEST(C3dDialects, AnalogFilesWithoutARateOfTheirOwn) {
  C3dParts parts = parts_of_take(0);
  erase_parameter(parts.parameters, "POINT", "RATE");
  parts.header.rate_hz = 0.0F;
  const C3dReadResult r = read_encoded(put_together(parts));
  EXPECT_DOUBLE_EQ(r.take.rate_hz, 100.0);
  EXPECT_TRUE(has_finding(r, "C3D306"));
  EXPECT_FALSE(has_errors(r.findings));
}

TEST(C3dDialects, AnalogFilesWithoutAPointGroup) {
  C3dParts parts = parts_of_take(0);
  std::erase_if(parts.parameters.groups, [](const C3dGroup& g) { return g.name == "POINT"; });
  const C3dReadResult r = read_encoded(put_together(parts, false));
  EXPECT_EQ(r.take.frame_count(), 20U);
  EXPECT_EQ(r.take.analog.channels.size(), 2U);
  EXPECT_FALSE(has_errors(r.findings));
}

TEST(C3dDialects, FirstFrameZeroIsCountedEitherWay) {
  for (const unsigned last : {19U, 20U}) {
    C3dParts parts = parts_of_take(3);
    parts.header.first_frame = 0;
    parts.header.last_frame = static_cast<uint16_t>(last);
    const C3dReadResult r = read_encoded(put_together(parts));
    EXPECT_EQ(r.take.frame_count(), 20U);
    EXPECT_EQ(r.take.first_frame, 1);
    EXPECT_TRUE(has_finding(r, "C3D105"));
    EXPECT_FALSE(has_errors(r.findings));
  }
}

TEST(C3dDialects, MissingLabelsAndFramesAreNoErrors) {
  C3dParts parts = parts_of_take(3);
  erase_parameter(parts.parameters, "POINT", "FRAMES");
  parts.parameters.set("POINT", texts_parameter("LABELS", {"A"}));
  const C3dReadResult r = read_encoded(put_together(parts));
  EXPECT_EQ(r.take.frame_count(), 20U);
  EXPECT_TRUE(has_finding(r, "C3D320"));
  EXPECT_TRUE(has_finding(r, "C3D401"));
  EXPECT_FALSE(has_errors(r.findings));
}

TEST(C3dDialects, OneEventWhoseTimeHasOneDimension) {
  C3dParts parts = parts_of_take(3);
  C3dParameter* times = parts.parameters.find("EVENT", "TIMES");
  ASSERT_NE(times, nullptr);
  times->numbers = {1.0, 5.5};
  times->dimensions = {2};
  parts.header.events.clear();
  const C3dReadResult r = read_encoded(put_together(parts));
  ASSERT_EQ(r.take.events.size(), 1U);
  EXPECT_DOUBLE_EQ(r.take.events[0].time_s, 65.5);
}

TEST(C3dDialects, ChannelsThatOnlyTheAnalogGroupClaims) {
  C3dParts parts = test::take_apart(encode_c3d(test::make_take(20, 3)));
  parts.parameters.set("ANALOG", integer_parameter("USED", {4}));
  parts.parameters.set("ANALOG", real_parameter("RATE", {100}));
  const C3dReadResult r = read_encoded(put_together(parts));
  EXPECT_EQ(r.take.frame_count(), 20U);
  EXPECT_TRUE(r.take.analog.channels.empty());
  EXPECT_TRUE(has_finding(r, "C3D305"));
}

}  // namespace
}  // namespace kinemesh::c3d_dialects_test
