#include "capture/edit_list.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "capture/c3d/parameter_access.h"
#include "capture/c3d/writer.h"
#include "capture/edit/operation.h"
#include "capture/edit/timeline.h"
#include "capture/session.h"
#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::edit_list_test {
namespace {

MarkerSequence edited(const MarkerSequence& take, const std::string& toml) {
  return apply_edits(take, parse_edits(toml, "edits.toml")).take;
}

/// Forty frames at 100 Hz of three markers, two analog channels of five samples a frame, an event.
MarkerSequence small_take() {
  MarkerSequence take = test::make_take(40, 3);
  test::add_analog(take, 2, 5);
  take.events = {{.label = "start", .time_s = 0.05}, {.label = "peak", .time_s = 0.20}};
  return take;
}

std::string message_of(const std::string& toml, const MarkerSequence& take) {
  try {
    edited(take, toml);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(EditList, CropKeepsEverythingAndShiftsIt) {
  const MarkerSequence take = small_take();
  const MarkerSequence out = edited(take, "[[edit]]\ndo = \"crop\"\nfrom = 11\nto = 30\n");
  ASSERT_EQ(out.frame_count(), 20U);
  EXPECT_EQ(out.first_frame, 1);
  for (std::size_t f = 0; f < 20; ++f) {
    for (std::size_t m = 0; m < 3; ++m) {
      EXPECT_EQ(out.position(f, m), take.position(f + 10, m));
      EXPECT_EQ(out.valid(f, m), take.valid(f + 10, m));
    }
  }
  ASSERT_EQ(out.analog.values.size(), 20U * 10U);
  EXPECT_EQ(out.analog.values[0], take.analog.values[100]);
  ASSERT_EQ(out.events.size(), 1U);  // the other lies before
  EXPECT_EQ(out.events[0].label, "peak");
  EXPECT_NEAR(out.events[0].time_s, 0.10, 1e-12);
  // Written as C3D and read again it is the same.
  MarkerSequence back = test::read_encoded(encode_c3d(out)).take;
  ASSERT_EQ(back.events.size(), 1U);
  EXPECT_NEAR(back.events[0].time_s, 0.10, 1e-6);
  back.events = out.events;  // whose times a C3D file rounds to floats
  test::expect_same_take(out, back, 0.0F, 0.1F, 0.0F);
}

TEST(EditList, TheOriginalStaysAndTheListReadsBackAlike) {
  const MarkerSequence take = small_take();
  const std::string toml =
      "[[edit]]\ndo = \"rename\"\nmarker = \"M2\"\nto = \"nose\"\n\n"
      "[[edit]]\ndo = \"delete\"\nmarkers = [\"M1\", \"x*\"]\nfrom = 5\nto = 9\n\n"
      "[[edit]]\ndo = \"filter\"\nfilter = \"median\"\nwindow = 5\n";
  const EditList edits = parse_edits(toml, "edits.toml");
  const EditResult result = apply_edits(take, edits);
  ASSERT_EQ(result.done.size(), 3U);
  EXPECT_EQ(result.done[0], "renamed M2 to nose");
  EXPECT_EQ(result.done[1], "deleted M1 in frames 5 to 9; nothing is called 'x*'");
  EXPECT_EQ(take.markers()[1].label, "M2");
  EXPECT_EQ(result.take.markers()[1].label, "nose");
  EXPECT_FALSE(result.take.valid(4, 0));
  const std::string again = edits_toml(edits);
  EXPECT_EQ(edits_toml(parse_edits(again, "again.toml")), again);
  EXPECT_NE(again.find("window = 5"), std::string::npos);
  EXPECT_EQ(again.find("degree"), std::string::npos);  // at its default
}

TEST(EditList, SwapMoveAndDelete) {
  MarkerSequence take = small_take();
  MarkerSequence out = edited(take, "[[edit]]\ndo = \"swap\"\na = \"M1\"\nb = \"M3\"\nfrom = 21\n");
  EXPECT_EQ(out.position(19, 0), take.position(19, 0));
  EXPECT_EQ(out.position(20, 0), take.position(20, 2));
  EXPECT_EQ(out.valid(33, 2), take.valid(33, 0));
  for (std::size_t f = 0; f < 40; ++f) {
    const bool first = f < 15;
    take.flags()[take.sample(f, 0)] = first ? SampleFlag::valid : 0;
    take.flags()[take.sample(f, 1)] = first ? 0 : SampleFlag::valid;
  }
  out = edited(take,
               "[[edit]]\ndo = \"move\"\nmarker = \"M2\"\ninto = \"M1\"\n"
               "[[edit]]\ndo = \"delete\"\nmarkers = \"M2\"\n");
  ASSERT_EQ(out.marker_count(), 2U);
  EXPECT_EQ(out.position(30, 0), take.position(30, 1));
  EXPECT_TRUE(out.valid(30, 0));
  EXPECT_EQ(out.analog.values.size(), take.analog.values.size());
}

TEST(EditList, JoinPutsTakesBehindEachOther) {
  const MarkerSequence a = small_take();
  MarkerSequence b = small_take();
  b.markers()[2].label = "extra";
  b.first_frame = 101;
  b.events = {{.label = "late", .time_s = 1.1}};  // tenth frame of b
  std::vector<std::string> notes;
  const MarkerSequence out = join_takes(a, b, 10, &notes);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0], "1 marker of it had none of the same subject and label in the take");
  ASSERT_EQ(out.frame_count(), 90U);
  ASSERT_EQ(out.marker_count(), 4U);
  EXPECT_EQ(out.position(50, 1), b.position(0, 1));
  EXPECT_EQ(out.position(51, 3), b.position(1, 2));
  EXPECT_FALSE(out.valid(45, 0));
  EXPECT_FALSE(out.valid(60, 2));
  EXPECT_EQ(out.analog.values[50 * 10], b.analog.values[0]);
  EXPECT_EQ(out.analog.values[45 * 10], 0.0F);
  EXPECT_NEAR(out.events.back().time_s, 0.6, 1e-12);
  b.rate_hz = 60.0;
  EXPECT_THROW(join_takes(a, b, 0), UsageError);
}

TEST(EditList, TakesWithOtherAxesAreNotJoined) {
  MarkerSequence a = small_take();
  MarkerSequence b = small_take();
  a.origin.x_screen = b.origin.x_screen = "+X";
  a.origin.y_screen = "+Y";
  EXPECT_EQ(join_takes(a, b, 0).frame_count(), 80U);  // the second does not say
  b.origin.y_screen = "+Z";
  EXPECT_THROW(join_takes(a, b, 0), UsageError);
  b.origin.y_screen = "+Y ";
  EXPECT_EQ(join_takes(a, b, 0).frame_count(), 80U);
}

TEST(EditList, ResampleFollowsTheMotion) {
  auto take = MarkerSequence::invalid(121, {{.label = "A"}, {.label = "B"}}, 120.0);
  const auto at = [](double t) {
    return Eigen::Vector3f(static_cast<float>(10 * std::sin(6 * t)), static_cast<float>(t), 5.0F);
  };
  for (std::size_t f = 0; f < 121; ++f) {
    take.position(f, 0) = take.position(f, 1) = at(static_cast<double>(f) / 120.0);
    take.flags()[take.sample(f, 0)] = SampleFlag::valid;
    take.flags()[take.sample(f, 1)] = f > 40 && f < 60 ? 0 : SampleFlag::valid;
  }
  test::add_analog(take, 1, 10);
  for (std::size_t i = 0; i < take.analog.values.size(); ++i) {
    take.analog.values[i] = static_cast<float>(i);
  }
  for (const double rate : {50.0, 60.0, 120.0, 250.0}) {
    const MarkerSequence out = resample_take(take, rate);
    ASSERT_EQ(out.frame_count(), static_cast<std::size_t>(rate) + 1);
    for (std::size_t f = 0; f < out.frame_count(); ++f) {
      const double t = static_cast<double>(f) / rate;
      EXPECT_LT((out.position(f, 0) - at(t)).norm(), 2e-3F) << rate << " at " << f;
      const bool hidden = t > 40.0 / 120.0 + 1e-9 && t < 60.0 / 120.0 - 1e-9;
      EXPECT_EQ(out.valid(f, 1), !hidden) << rate << " at " << f;
    }
    ASSERT_EQ(out.analog.values.size(), out.frame_count() * out.analog.samples_per_frame);
    const std::size_t middle = out.frame_count() / 2 * out.analog.samples_per_frame;
    EXPECT_NEAR(out.analog.values[middle], 1200.0 * (out.frame_count() / 2) / rate, 1.0);
  }
  const MarkerSequence same = resample_take(take, 120.0);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(same.position(i, 1), take.position(i, 1));
}

TEST(EditList, AnonymiseLeavesNoName) {
  MarkerSequence take = small_take();
  for (Marker& m : take.markers()) m.subject = "Maria";
  take.events[0].subject = "Maria";
  take.events[1].label = "maria smiles";
  take.parameters.set("SUBJECTS", text_parameter("NAMES", "Maria"));
  take.parameters.set("SUBJECTS", text_parameter("LABEL_PREFIXES", "Maria:"));
  take.parameters.set("SUBJECTS", integer_parameter("USED", {1}));
  take.parameters.set("PATIENT", text_parameter("BIRTH", "1980-01-01"));
  take.parameters.set("TRIAL", text_parameter("NAME", "Maria 1"));
  take.parameters.set("MANUFACTURER", text_parameter("COMPANY", "Vicon"));
  take.parameters.set("ANALOG", text_parameter("DESCRIPTIONS", "EMG of Maria"));
  take.markers()[1].label = "Maria_chin";
  take.markers()[2].subject = "Al";
  take.markers()[2].label = "al-malar_AL";
  const std::string bytes = encode_c3d(edited(take, "[[edit]]\ndo = \"anonymise\"\n"));
  std::string low = bytes;
  for (char& c : low) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  EXPECT_EQ(low.find("maria"), std::string::npos);
  EXPECT_EQ(low.find("1980"), std::string::npos);
  EXPECT_NE(low.find("vicon"), std::string::npos);
  const MarkerSequence back = test::read_encoded(bytes).take;
  EXPECT_EQ(back.markers()[0].subject, "S1");
  EXPECT_EQ(back.markers()[0].label, "M1");
  EXPECT_EQ(back.markers()[1].label, "S1_chin");
  EXPECT_EQ(back.markers()[2].label, "S2-malar_S2");
  EXPECT_EQ(back.events[0].subject, "S1");
}

TEST(EditList, SubjectsEventsUnitsAxes) {
  MarkerSequence take = small_take();
  take.markers()[0].subject = "a";
  take.markers()[1].subject = "b";
  take.markers()[2].subject = "b";
  take.origin.y_screen = "+Z";
  const MarkerSequence out = edited(
      take,
      "[[edit]]\ndo = \"merge-subjects\"\nsubjects = [\"a\", \"b\"]\ninto = \"c\"\n"
      "[[edit]]\ndo = \"add-event\"\nlabel = \"smile\"\nframe = 11\n"
      "[[edit]]\ndo = \"units\"\nunit = \"m\"\n[[edit]]\ndo = \"axes\"\npreset = \"y-up\"\n");
  for (const Marker& m : out.markers()) EXPECT_EQ(m.subject, "c");
  EXPECT_EQ(out.events[1].label, "smile");
  EXPECT_NEAR(out.events[1].time_s, 0.1, 1e-12);
  const Eigen::Vector3f p = take.position(3, 1);
  EXPECT_EQ(out.position(3, 1), Eigen::Vector3f(p.x(), p.z(), -p.y()));
  EXPECT_EQ(out.origin.y_screen, "+Y");
  const MarkerSequence back = test::read_encoded(encode_c3d(out)).take;
  EXPECT_EQ(back.origin.unit, "m");
  EXPECT_LT((back.position(3, 1) - out.position(3, 1)).norm(), 1e-3F);
  const MarkerSequence again = edited(out, "[[edit]]\ndo = \"axes\"\npreset = \"z-up\"\n");
  EXPECT_EQ(again.position(3, 1), p);
  take.markers()[1].label = "M1";
  EXPECT_NE(message_of("[[edit]]\ndo = \"merge-subjects\"\ninto = \"c\"\n", take).find("M1"),
            std::string::npos);
}

TEST(EditList, AxesFollowWhatPointsRightOnTheScreen) {
  MarkerSequence take = small_take();
  take.origin.x_screen = "-Y";  // right; up is z, so that x points away from the viewer
  take.origin.y_screen = "+Z";
  const Eigen::Vector3f p = take.position(3, 1);
  const MarkerSequence z_up = edited(take, "[[edit]]\ndo = \"axes\"\npreset = \"z-up\"\n");
  EXPECT_EQ(z_up.position(3, 1), Eigen::Vector3f(-p.y(), p.x(), p.z()));
  EXPECT_EQ(z_up.origin.x_screen, "+X");
  EXPECT_EQ(z_up.origin.y_screen, "+Z");
  const MarkerSequence y_up = edited(take, "[[edit]]\ndo = \"axes\"\npreset = \"y-up\"\n");
  EXPECT_EQ(y_up.position(3, 1), Eigen::Vector3f(-p.y(), p.z(), -p.x()));
  take.origin.y_screen = "-X";
  const MarkerSequence hanging = edited(take, "[[edit]]\ndo = \"axes\"\npreset = \"z-up\"\n");
  EXPECT_EQ(hanging.position(3, 1).z(), -p.x());
  EXPECT_EQ(hanging.position(3, 1).x(), -p.y());
}

TEST(EditList, ForcePlatesChangeTheirUnitWithThePoints) {
  MarkerSequence take = small_take();
  take.parameters.set(
      "FORCE_PLATFORM",
      real_parameter("CORNERS", {0, 0, 0, 400, 0, 0, 400, 600, 0, 0, 600, 0}, {3, 4, 1}));
  take.parameters.set("FORCE_PLATFORM", real_parameter("ORIGIN", {0, 0, -40}, {3, 1}));
  const MarkerSequence out = edited(take, "[[edit]]\ndo = \"units\"\nunit = \"m\"\n");
  EXPECT_NEAR(out.parameters.find("FORCE_PLATFORM", "CORNERS")->numbers[7], 0.6, 1e-12);
  EXPECT_NEAR(out.parameters.find("FORCE_PLATFORM", "ORIGIN")->numbers[2], -0.04, 1e-12);
}

TEST(EditList, TwinsStayApartWhenTakesAreJoined) {
  const test::TemporaryFolder folder;
  MarkerSequence take = small_take();
  take.markers()[1].label = take.markers()[0].label;
  write_c3d(take, folder.path() / "second.c3d");
  EditList join = parse_edits("[[edit]]\ndo = \"join\"\nfile = \"second.c3d\"\n", "edits.toml");
  join.folder = folder.path();
  const MarkerSequence out = apply_edits(take, join).take;
  ASSERT_EQ(out.marker_count(), 3U);
  for (std::size_t m = 0; m < 3; ++m) {
    EXPECT_LT((out.position(43, m) - take.position(3, m)).norm(), 1e-3F) << m;
  }
}

TEST(EditList, TwinsAreOneOnlyWhereOneGoesOnWhereTheOtherEnds) {
  for (const bool same : {true, false}) {
    MarkerSequence take = test::make_take(40, 5);
    take.markers()[1].label = take.markers()[0].label;
    for (std::size_t f = 0; f < 40; ++f) {
      take.flags()[take.sample(f, 0)] = f < 18 ? SampleFlag::valid : 0;
      take.flags()[take.sample(f, 1)] = f < 20 ? 0 : SampleFlag::valid;
      if (same) take.position(f, 1) = take.position(f, 0);
    }
    const MarkerSequence out = edited(take, "[[edit]]\ndo = \"unite-twins\"\n");
    ASSERT_EQ(out.marker_count(), same ? 4U : 5U);
    EXPECT_EQ(out.valid(30, 0), same);
    if (!same) {
      EXPECT_EQ(out.markers()[1].label, take.markers()[0].label + "_2");
    }
  }
}

TEST(EditList, ALabelOfTwoSubjectsMustSayWhose) {
  MarkerSequence take = small_take();
  take.markers()[0].subject = "anna";
  take.markers()[1].subject = "ben";
  take.markers()[0].label = take.markers()[1].label = "CHIN";
  const std::string bare = "[[edit]]\ndo = \"rename\"\nto = \"X\"\nmarker = \"CHIN\"\n";
  const std::string message = message_of(bare, take);
  EXPECT_NE(message.find("several subjects"), std::string::npos) << message;
  EXPECT_NE(message.find("\"anna:CHIN\" or \"ben:CHIN\""), std::string::npos) << message;
  const MarkerSequence out =
      edited(take, "[[edit]]\ndo = \"rename\"\nto = \"X\"\nmarker = \"ben:CHIN\"\n");
  EXPECT_EQ(out.markers()[0].label, "CHIN");
  EXPECT_EQ(out.markers()[1].label, "X");
  const std::string donor = "[[edit]]\ndo = \"fill\"\nfill = \"pattern\"\ndonor = \"CHIN\"\n";
  EXPECT_NE(message_of(donor, take).find("several subjects"), std::string::npos);
}

TEST(EditList, StagesAreSteps) {
  const MarkerSequence out = edited(small_take(),
                                    "[[edit]]\ndo = \"fill\"\nfill = \"cubic\"\n"
                                    "[[edit]]\ndo = \"filter\"\ncutoff = 10\n");
  for (std::size_t f = 0; f < 40; ++f) EXPECT_TRUE(out.valid(f, 1));
}

TEST(EditList, AFewWordsAskForNoMoreMemoryThanThereIs) {
  const MarkerSequence take = small_take();  // 40 frames of 3 markers at 100 Hz
  EXPECT_THROW(join_takes(take, take, 33'333'333), UsageError);
  MarkerSequence slow = take;
  slow.rate_hz = 0.5;
  try {
    resample_take(slow, 1e6);
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("234 million samples"), std::string::npos) << e.what();
  }
}

TEST(EditList, SaysWhatIsWrongAndWhere) {
  const MarkerSequence take = small_take();
  const auto says = [&](const std::string& toml, const std::string& part) {
    const std::string message = message_of(toml, take);
    EXPECT_NE(message.find(part), std::string::npos) << "\"" << message << "\"";
  };
  says("[[edit]]\nto = 3\n", "line 1");
  says("[[edit]]\ndo = \"crp\"\n", "Did you mean 'crop'?");
  says("[[edit]]\ndo = \"crop\"\nstart = 3\n", "line 3");
  says("[[edit]]\ndo = \"crop\"\nfrom = 0.5\n", "from");
  says("[[edit]]\ndo = \"crop\"\nfrom = 30\nto = 41\n", "edit 1 (crop)");
  says("[[edit]]\ndo = \"swap\"\na = \"M1\"\nb = \"M9\"\n", "M9");
  says("[[edit]]\ndo = \"swap\"\na = \"M1\"\nb = \"M1\"\n", "same marker");
  says("[[edit]]\ndo = \"swap\"\na = \"M1\"\n", "one is missing");
  says("[[edit]]\ndo = \"delete\"\nmarkers = [\"*\"]\n", "nothing would be left");
  says("[[edit]]\ndo = \"rename\"\nmarker = \"M1\"\nto = \"M2\"\n", "already has");
  says("[[edit]]\ndo = \"axes\"\n", "which axis is up");
  says("[[edit]]\ndo = \"add-event\"\nlabel = \"late\"\ntime = 3\n", "lasts from 0.000 to 0.390 s");
  says("[[edit]]\ndo = \"delete\"\nmarkers = [\"Nose*\"]\n", "'Nose*' matches no marker");
  says("[[edit]]\ndo = \"join\"\nfile = \"missing.c3d\"\n", "missing.c3d");
  says("[[edit]]\ndo = \"units\"\nunit = \"parsec\"\n", "parsec");
  says("[[edit]]\ndo = \"units\"\nunit = \"inch\"\n", "mm, cm or m");
  says("[[edit]]\ndo = \"add-event\"\nlabel = \"x\"\n", "both are missing");
  says("[[edit]]\ndo = \"add-event\"\nlabel = \"x\"\nframe = 3\ntime = 0.1\n", "both say when");
  says("[[edit]]\ndo = \"resample\"\n", "missing");
  says("[[edit]]\ndo = \"resample\"\nrate = 1000000000\n", "rate");
  says("[[edit]]\ndo = \"merge-subjects\"\nsubjects = [\"zoe\"]\ninto = \"c\"\n", "'zoe'");
  says("[[edit]]\ndo = \"crop\"\nfrom = 30\nto = 20\n", "comes before it");
  says("[[edit]]\ndo = \"rename\"\nto = \"X\"\n", "'marker' names a marker");
  says("[[edit]]\ndo = \"filter\"\nfilter = \"median\"\ncutoff = 6\n", "only butterworth");
  says("edit = 3\n", "edit");
  says("[edit\n", "line 1");
  says("[[edit]]\ndo = \"move\"\nmarker = \"M1\"\ninto = \"M2\"\n", "measured there");
}

}  // namespace
}  // namespace kinemesh::edit_list_test
