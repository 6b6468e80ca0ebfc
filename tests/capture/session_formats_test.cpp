// Tables in and out: TRC, our CSV, Motive and QTM exports, JSON and NumPy archives.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "capture/formats/motive_csv.h"
#include "capture/formats/qtm_tsv.h"
#include "capture/formats/session_csv.h"
#include "capture/formats/session_export.h"
#include "capture/formats/trc.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "mesh/formats/npz.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::session_formats_test {
namespace {

/// Two subjects with a gap, an estimated sample, an angle, a point at the origin, events and
/// analog.
MarkerSequence sample_take() {
  MarkerSequence take = MarkerSequence::invalid(
      6,
      {{.label = "LFHD", .subject = "Anna"},
       {.label = "Wange, \"links\"", .subject = ""},
       {.label = "*12", .kind = MarkerKind::unlabelled},
       {.label = "LKneeAngle", .subject = "Anna", .kind = MarkerKind::angle, .unit = "deg"},
       {.label = "a:b"}},
      100.0);
  for (std::size_t f = 0; f < 6; ++f) {
    for (std::size_t m = 0; m < 5; ++m) {
      for (int k = 0; k < 3; ++k) {
        take.position(f, m)[k] =
            static_cast<float>(std::numbers::pi * (100.0 * static_cast<double>(m) +
                                                   10.0 * static_cast<double>(f) + k));
      }
      take.flags()[take.sample(f, m)] = SampleFlag::valid;
      take.residuals()[take.sample(f, m)] = 0.1F * static_cast<float>(m);
    }
  }
  take.flags()[take.sample(2, 0)] = 0;
  take.flags()[take.sample(3, 1)] |= SampleFlag::filled;
  take.position(4, 4).setZero();
  take.first_frame = 37;
  take.events = {{"Smile, broad", "General", "Anna", 0.39}, {"End", "", "", 0.4}};
  take.analog.channels = {{"Fz1", "N", "force"}, {"EMG", "V", ""}};
  take.analog.rate_hz = 200.0;
  take.analog.samples_per_frame = 2;
  take.analog.values = Buffer<float>(24);
  for (std::size_t i = 0; i < 24; ++i) take.analog.values[i] = 0.25F * static_cast<float>(i) - 1.0F;
  return take;
}

/// Labels, kinds, validity and the values of valid samples alike; values bit by bit.
void expect_same_points(const MarkerSequence& a, const MarkerSequence& b) {
  ASSERT_EQ(a.frame_count(), b.frame_count());
  ASSERT_EQ(a.marker_count(), b.marker_count());
  for (std::size_t m = 0; m < a.marker_count(); ++m) EXPECT_EQ(a.markers()[m], b.markers()[m]) << m;
  EXPECT_EQ(validity_codes(a), validity_codes(b));
  for (std::size_t i = 0; i < a.sample_count(); ++i) {
    if ((a.flags()[i] & SampleFlag::valid) == 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(a.positions()[3 * i + k], b.positions()[3 * i + k]);
  }
  EXPECT_EQ(a.rate_hz, b.rate_hz);
  EXPECT_EQ(a.first_frame, b.first_frame);
}

TEST(SessionCsv, ComesBackValueByValue) {
  const test::TemporaryFolder folder;
  const MarkerSequence take = sample_take();
  const SessionExportResult out = export_session(take, folder.path() / "take.csv");
  ASSERT_EQ(out.files.size(), 3U);
  EXPECT_EQ(out.files[1].filename(), "take.analog.csv");
  EXPECT_EQ(out.files[2].filename(), "take.events.csv");
  const MarkerSequence back = read_session_csv(TableText(read_file(out.files[0]), "take.csv"));
  expect_same_points(take, back);
  EXPECT_EQ(take.events, back.events);
  for (std::size_t i = 0; i < take.sample_count(); ++i) {
    if ((take.flags()[i] & SampleFlag::valid) == 0) continue;
    EXPECT_EQ(take.residuals()[i], back.residuals()[i]);
  }
  const std::string analog = read_file(out.files[1]);
  EXPECT_TRUE(analog.starts_with("time_s,Fz1 (N),EMG (V)\n0.36,-1,-0.75\n0.365,-0.5,-0.25\n"))
      << analog;
  EXPECT_EQ(read_file(out.files[2]),
            "time_s,label,context,subject\n0.39,\"Smile, broad\",General,Anna\n0.4,End,,\n");
}

TEST(SessionCsv, KeepsTheUncertaintyOfEstimatedSamples) {
  const test::TemporaryFolder folder;
  MarkerSequence take = sample_take();
  take.add_uncertainty();
  take.uncertainty()[take.sample(3, 1)] = 0.7F;
  const SessionExportResult out = export_session(take, folder.path() / "take.csv");
  const MarkerSequence back = read_session_csv(TableText(read_file(out.files[0]), "take.csv"));
  expect_same_points(take, back);
  EXPECT_TRUE(std::ranges::equal(take.uncertainty(), back.uncertainty()));
  const SessionExportResult trc = export_session(take, folder.path() / "take.trc");
  EXPECT_TRUE(std::ranges::count(trc.left_out, "the uncertainty of filled samples") == 1);
}

TEST(SessionCsv, ReadsWhatASpreadsheetSavedAgain) {
  const TableText text(
      "\xEF\xBB\xBF# kinemesh points csv 1;;;;\r\n# rate_hz;50;;;\r\n"
      "frame;time_s;A.x;A.y;A.z\r\n1;0;1,5;-2,25;3\r\n2;0,02;;;\r\n4;0,06;4;5;6\r\n;;;;\r\n",
      "saved.csv");
  const MarkerSequence take = read_session_csv(text);
  ASSERT_EQ(take.frame_count(), 4U);  // frame 3 is missing: a gap
  EXPECT_EQ(take.rate_hz, 50.0);
  EXPECT_EQ(take.position(0, 0), Eigen::Vector3f(1.5F, -2.25F, 3.0F));
  EXPECT_FALSE(take.valid(1, 0));
  EXPECT_FALSE(take.valid(2, 0));
  EXPECT_TRUE(take.valid(3, 0));
}

TEST(SessionCsv, RateComesFromTimesWithoutTheComment) {
  const MarkerSequence take = read_session_csv(TableText(
      "frame,time_s,A.x,A.y,A.z\n10,0.15,1,2,3\n11,0.166667,1,2,3\n12,0.183333,1,2,3\n", "f"));
  EXPECT_EQ(take.rate_hz, 60.0);
  EXPECT_EQ(take.first_frame, 10);
}

/// The error of reading `text` as our CSV.
template <class Read>
std::string error_of(const std::string& text, Read read) {
  try {
    read(TableText(text, "bad.csv"), TableReadOptions{}, RunContext());
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(SessionCsv, ErrorsNameFileLineAndMarker) {
  const std::string head = "frame,time_s,A.x,A.y,A.z\n";
  const auto error = [&head](const std::string& rows) {
    return error_of(head + rows, read_session_csv);
  };
  EXPECT_EQ(error("1,0,1,2,3\n2,0.01,1,x,3\n"), "bad.csv: line 3: marker 'A': 'x' is no number");
  EXPECT_EQ(error("1,0,1,,3\n2,0.01,1,2,3\n"),
            "bad.csv: line 2: marker 'A': some coordinates are missing");
  EXPECT_EQ(error("2,0,1,2,3\n2,0.01,1,2,3\n"),
            "bad.csv: line 3: frame 2 follows frame 2. Frame numbers must ascend");
  EXPECT_EQ(error("1.5,0,1,2,3\n"), "bad.csv: line 2: the frame number '1.5' is no whole number");
  EXPECT_EQ(error("1,late,1,2,3\n"), "bad.csv: line 2: the time 'late' is no number");
  EXPECT_EQ(error(""), "bad.csv: line 2: the table holds no frame");
  EXPECT_EQ(error("1,0,1,2,3\n"),
            "bad.csv: line 2: the frame rate is not known. Say it with --rate, or export with the "
            "header or with a time "
            "column");
  EXPECT_EQ(error("1,0,1,2,3\n900000000000,9,1,2,3\n999000000000,19,1,2,3\n"),
            "bad.csv: line 4: frame 999000000000 follows far too late");
  EXPECT_EQ(error_of("# kinemesh points csv 1\n", read_session_csv),
            "bad.csv: line 2: the row of column names is missing");
  EXPECT_EQ(error_of("frame,time_s,A.x,A.z\n1,0,1,1\n", read_session_csv),
            "bad.csv: line 1: behind 'A.x' the columns 'A.y' and 'A.z' must follow");
  EXPECT_EQ(error_of("frame,time_s\n1,0\n", read_session_csv),
            "bad.csv: line 2: the table names no marker");
  EXPECT_THROW(TableText(std::string("a\0b", 3), "f"), InputError);
  EXPECT_THROW(TableText("\xFF\xFE"
                         "f",
                         "f"),
               InputError);
}

TEST(SessionCsv, AFileCutOffInItsLastLineLosesThatFrameOnly) {
  const std::string whole = "# rate_hz,10\nframe,time_s,A.x,A.y,A.z\n1,0,1,2,3\n2,0.1,4,5,6\n";
  std::vector<std::string> warnings;
  RunContext ctx;
  ctx.set_log([&warnings](LogLevel, std::string_view text) { warnings.emplace_back(text); });
  const MarkerSequence take =
      read_session_csv(TableText(whole.substr(0, whole.size() - 3), "cut.csv"), {}, ctx);
  EXPECT_EQ(take.frame_count(), 1U);
  EXPECT_EQ(warnings, std::vector<std::string>{
                          "cut.csv: line 4: the file is cut off here; this frame is left out"});
}

TEST(SessionCsv, SaysWhatItCannotHold) {
  const test::TemporaryFolder folder;
  MarkerSequence take = sample_take();
  EXPECT_TRUE(export_session(take, folder.path() / "a.csv").left_out.empty());
  take.camera_masks()[0] = 3;
  EXPECT_EQ(export_session(take, folder.path() / "b.csv").left_out,
            std::vector<std::string>{"camera masks"});
}

TEST(Trc, ComesBackValueByValue) {
  const test::TemporaryFolder folder;
  const MarkerSequence take = sample_take();
  const SessionExportResult out = export_session(take, folder.path() / "take.trc");
  EXPECT_EQ(out.left_out, (std::vector<std::string>{"residuals", "1 angle, force or other column",
                                                    "2 analog channels", "2 events"}));
  TableReadOptions zeros_are_points{.zero_is_gap = false};
  const MarkerSequence back =
      read_trc(TableText(read_file(folder.path() / "take.trc"), "take.trc"), zeros_are_points);
  ASSERT_EQ(back.marker_count(), 4U);  // all but the angle
  EXPECT_EQ(back.first_frame, 37);
  EXPECT_EQ(back.rate_hz, 100.0);
  EXPECT_EQ(back.markers()[0].subject, "Anna");
  EXPECT_EQ(back.markers()[2].kind, MarkerKind::unlabelled);
  for (std::size_t f = 0; f < 6; ++f) {
    for (std::size_t m = 0; m < 4; ++m) {
      const std::size_t from = m < 3 ? m : 4;
      EXPECT_EQ(back.valid(f, m), take.valid(f, from));
      if (take.valid(f, from)) {
        EXPECT_EQ(back.position(f, m), take.position(f, from));
      }
    }
  }
  // A point at the origin is a gap unless the reader is told otherwise.
  EXPECT_FALSE(read_trc(TableText(read_file(folder.path() / "take.trc"), "take.trc")).valid(4, 3));
}

TEST(Trc, ReadsTheDialects) {
  // OpenSim: metres, packed labels, no line of axes, no blank line; Cortex: blanks in the values.
  const MarkerSequence take =
      read_trc(TableText("PathFileType\t4\t(X/Y/Z)\tC:\\data\\walk.trc\r\n"
                         "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDat"
                         "aStartFrame\tOrigNumFrames\r\n"
                         "   60.0\t\t   60.0\t\t     3\t\t     2\tm\t   60.0\t     1\t     3\r\n"
                         "Frame#\tTime\tR.ASIS\tL.ASIS\r\n"
                         "1\t0.000000\t0.5\t1\t-0.25\t0.1\t0.2\t0.3\r\n"
                         "2\t0.016667\t0.5\t1\t-0.25\t\t\t\r\n"
                         "3\t0.033333\t0.5\t1\t-0.25\tNaN\tNaN\tNaN\r\n",
                         "walk.trc"));
  ASSERT_EQ(take.marker_count(), 2U);
  EXPECT_EQ(take.rate_hz, 60.0);
  EXPECT_EQ(take.markers()[1].label, "L.ASIS");
  EXPECT_EQ(take.position(0, 0), Eigen::Vector3f(500, 1000, -250));
  EXPECT_EQ(take.position(0, 1), Eigen::Vector3f(100, 200, 300));
  EXPECT_FALSE(take.valid(1, 1));
  EXPECT_FALSE(take.valid(2, 1));
}

TEST(Trc, ErrorsNameTheLine) {
  EXPECT_EQ(error_of("PathFileType\t4\n", read_trc),
            "bad.csv: line 1: this is no TRC file: the line that begins with DataRate is missing");
  EXPECT_EQ(error_of("PathFileType\nDataRate\tUnits\n100\tmm\n", read_trc),
            "bad.csv: line 3: the line of marker names, which begins with Frame#, is missing");
  const std::string keys = "PathFileType\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n";
  EXPECT_EQ(error_of(keys + "100\t100\t1\t1\tfurlong\nFrame#\tTime\tA\n1\t0\t1\t2\t3\n", read_trc),
            "bad.csv: line 3: the unit 'furlong' is not known. Use mm, cm or m");
  EXPECT_EQ(error_of(keys + "fast\t100\t1\t1\tmm\nFrame#\tTime\tA\n1\t0\t1\t2\t3\n", read_trc),
            "bad.csv: line 3: 'fast' is no valid datarate");
  EXPECT_EQ(error_of(keys + "100\t100\t1\t1\tmm\nFrame#\tTime\tA\n1\t0\t1\t2\tz\n", read_trc),
            "bad.csv: line 5: marker 'A': 'z' is no number");
}

constexpr const char* motive =
    "Format Version,1.23,Take Name,Smile 01,Take Notes,,Capture Frame Rate,120.000000,Export Frame "
    "Rate,120.000000,Capture Start Time,2026-02-03 10.11.12.345 AM,Total Frames in Take,3,Total "
    "Exported Frames,3,Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global\n"
    "\n"
    ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,"
    "Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Marker,Marker,Marker,"
    "Marker,Marker,Marker\n"
    ",Name,Head,Head,Head,Head,Head,Head,Head,Head,Head:Marker1,Head:Marker1,Head:Marker1,"
    "Head:Marker1,Head:Marker1,Head:Marker1,Head:Marker1,\"Unlabeled 1025\",\"Unlabeled 1025\","
    "\"Unlabeled 1025\"\n"
    ",ID,\"AA\",\"AA\",\"AA\",\"AA\",\"AA\",\"AA\",\"AA\",\"AA\",1,1,1,1,2,2,2,3,3,3\n"
    ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,"
    "Position,Position,Marker Quality,Position,Position,Position,Position,Position,Position\n"
    "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z,,X,Y,Z,X,Y,Z\n"
    "0,0.000000,0,0,0,1,0.1,1.5,0.2,0.0003,0.11,1.6,0.21,1,0.12,1.61,0.22,,,\n"
    "1,0.008333,0,0,0,1,0.1,1.5,0.2,0.0003,0.11,1.6,0.21,1,,,,0.5,0.25,0.125\n"
    "2,0.016667,0,0,0,1,0.1,1.5,0.2,0.0003,0.11,1.6,0.21,1,0.13,1.62,0.23\n";

TEST(MotiveCsv, MeasuredMarkersComeFirstInMillimetres) {
  EXPECT_TRUE(looks_like_motive_csv("Format Version,1.23,Take Name"));
  const MarkerSequence take = read_motive_csv(TableText(motive, "smile.csv"));
  ASSERT_EQ(take.marker_count(), 4U);
  ASSERT_EQ(take.frame_count(), 3U);
  EXPECT_EQ(take.rate_hz, 120.0);
  EXPECT_EQ(take.first_frame, 1);
  EXPECT_EQ(take.markers()[0], (Marker{.label = "Marker1", .subject = "Head"}));
  EXPECT_EQ(take.markers()[1].kind, MarkerKind::unlabelled);
  EXPECT_EQ(take.markers()[2].kind, MarkerKind::virtual_point);
  EXPECT_EQ(take.markers()[3].kind, MarkerKind::virtual_point);
  EXPECT_EQ(take.find("Head:Marker1"), 0U);
  EXPECT_EQ(take.position(0, 0), Eigen::Vector3f(120, 1610, 220));
  EXPECT_FALSE(take.valid(1, 0));
  EXPECT_EQ(take.position(1, 1), Eigen::Vector3f(500, 250, 125));
  EXPECT_FALSE(take.valid(2, 1));  // trailing blanks may be left out
}

TEST(MotiveCsv, ReadsVersion125WithParentsAndTimecode) {
  const MarkerSequence take = read_motive_csv(TableText(
      "Format Version,1.25,Take Name,T,Capture Frame Rate,100.0,Length Units,Millimeters\r\n\r\n"
      ",Type,,Marker,Marker,Marker\r\n,Name,,Face:M1,Face:M1,Face:M1\r\n,ID,,x,x,x\r\n,Parent,,,,"
      "\r\n"
      ",,,Position,Position,Position\r\nFrame,Time (Seconds),TimeCode,X,Y,Z\r\n"
      "100,1.0,15:26:46:12.02,1,2,3\r\n101,1.01,15:26:46:12.03,4,5,6\r\n",
      "t.csv"));
  EXPECT_EQ(take.first_frame, 101);
  EXPECT_EQ(take.position(1, 0), Eigen::Vector3f(4, 5, 6));
}

TEST(MotiveCsv, ErrorsSayWhatToExport) {
  EXPECT_EQ(
      error_of("Format Version,1.23\n1,2,3\n", read_motive_csv),
      "bad.csv: line 3: the row that begins with Frame, Time (Seconds) is missing. Export from "
      "Motive with the header switched on, format version 1.2 or later");
  const std::string head = "Format Version,1.23,Capture Frame Rate,100,Length Units,Parsecs\n\n";
  const std::string rows =
      ",Type,Marker,Marker,Marker\n,Name,A,A,A\n,,Position,Position,Position\nFrame,Time,X,Y,Z\n0,"
      "0,1,2,3\n";
  EXPECT_EQ(error_of(head + rows, read_motive_csv),
            "bad.csv: line 1: the length unit 'Parsecs' is not known");
}

constexpr const char* qtm =
    "NO_OF_FRAMES\t3\nNO_OF_CAMERAS\t8\nNO_OF_MARKERS\t2\nFREQUENCY\t200\nNO_OF_ANALOG\t0\n"
    "ANALOG_FREQUENCY\t0\nDESCRIPTION\t--\nTIME_STAMP\t2026-02-03, 10:47:36.627\t94247.4\n"
    "DATA_INCLUDED\t3D\nEVENT\tSmile\t2\t0.00500\nMARKER_NAMES\tbrow_l\tjaw\t\n"
    "TRAJECTORY_TYPES\tMeasured\tVirtual\n";

TEST(QtmTsv, ReadsRowsWithAndWithoutFrameAndTime) {
  EXPECT_TRUE(looks_like_qtm("NO_OF_FRAMES\t3"));
  const std::string plain =
      std::string(qtm) + "1\t2\t3\t4\t5\t6\n1\t2\t3\t0.000\t0.000\t0.000\n\t\t\t4\t5\t6\n";
  const std::string timed = std::string(qtm) +
                            "Frame\tTime\tbrow_l X\tbrow_l Y\tbrow_l Z\tjaw X\tjaw Y\tjaw Z\n"
                            "1\t0.00000\t1\t2\t3\t4\t5\t6\n2\t0.00500\t1\t2\t3\t0\t0\t0\n"
                            "3\t0.01000\tNaN\tNaN\tNaN\t4\t5\t6\n";
  const std::string unnamed = std::string(qtm) +
                              "1\t0.00000\t1\t2\t3\t4\t5\t6\n2\t0.00500\t1\t2\t3\t0\t0\t0\n"
                              "3\t0.01000\t\t\t\t4\t5\t6\n";
  for (const std::string& text : {plain, timed, unnamed}) {
    const MarkerSequence take = read_qtm(TableText(text, "smile.tsv"));
    ASSERT_EQ(take.frame_count(), 3U);
    ASSERT_EQ(take.marker_count(), 2U);
    EXPECT_EQ(take.rate_hz, 200.0);
    EXPECT_EQ(take.markers()[0].label, "brow_l");
    EXPECT_EQ(take.markers()[1].kind, MarkerKind::virtual_point);
    EXPECT_EQ(take.position(2, 1), Eigen::Vector3f(4, 5, 6));
    EXPECT_FALSE(take.valid(1, 1));
    EXPECT_FALSE(take.valid(2, 0));
    EXPECT_EQ(take.events, (std::vector<Event>{{"Smile", "", "", 0.005}}));
  }
}

TEST(QtmTsv, ErrorsNameTheLine) {
  EXPECT_EQ(
      error_of("NO_OF_FRAMES\t1\nDATA_INCLUDED\t6D\nBODY_NAMES\tHead\n", read_qtm),
      "bad.csv: line 2: this is an export of 6D data. Export 3D data from QTM, with the header "
      "switched on");
  EXPECT_EQ(
      error_of("NO_OF_FRAMES\t1\nNO_OF_MARKERS\t3\nFREQUENCY\t100\nMARKER_NAMES\ta\tb\n1\t2\t3\n",
               read_qtm),
      "bad.csv: line 4: NO_OF_MARKERS announces 3 markers, MARKER_NAMES lists 2");
  EXPECT_EQ(error_of(std::string(qtm) + "1\t2\t3\t4\tfive\t6\n", read_qtm),
            "bad.csv: line 13: marker 'jaw': 'five' is no number");
}

TEST(SessionJson, HoldsEverything) {
  const test::TemporaryFolder folder;
  const MarkerSequence take = sample_take();
  export_session(take, folder.path() / "take.json");
  const nlohmann::json json = nlohmann::json::parse(read_file(folder.path() / "take.json"));
  EXPECT_EQ(json["format"], "kinemesh session 1");
  EXPECT_EQ(json["rate_hz"], 100.0);
  EXPECT_EQ(json["first_frame"], 37);
  EXPECT_EQ(json["markers"][3]["kind"], "angle");
  EXPECT_EQ(json["events"][0]["label"], "Smile, broad");
  EXPECT_TRUE(json["positions"][2][0][0].is_null());
  EXPECT_EQ(json["positions"][1][4][2].get<float>(), take.position(1, 4)[2]);
  EXPECT_EQ(json["valid"][3], (std::vector<int>{1, 2, 1, 1, 1}));
  EXPECT_EQ(json["times_s"].size(), 6U);
  EXPECT_EQ(json["analog"]["channels"][1]["unit"], "V");
  EXPECT_EQ(json["analog"]["values"].size(), 12U);
  EXPECT_EQ(json["analog"]["values"][11][1].get<float>(), 4.75F);
}

TEST(SessionNpz, HoldsEverything) {
  const test::TemporaryFolder folder;
  const MarkerSequence take = sample_take();
  export_session(take, folder.path() / "take.npz");
  const NpzFile npz = read_npz(folder.path() / "take.npz");
  EXPECT_EQ(npz_array(npz, "positions").shape, (std::vector<std::size_t>{6, 5, 3}));
  const std::vector<double> positions = npz_array(npz, "positions").numbers();
  EXPECT_TRUE(std::isnan(positions[3 * take.sample(2, 0)]));
  EXPECT_EQ(positions[3 * take.sample(1, 4)], take.position(1, 4)[0]);
  EXPECT_EQ(npz_array(npz, "labels").texts[1], "Wange, \"links\"");
  EXPECT_EQ(npz_array(npz, "analog").shape, (std::vector<std::size_t>{12, 2}));
  EXPECT_EQ(npz_array(npz, "event_times_s").numbers(), (std::vector<double>{0.39, 0.4}));
}

TEST(SessionExport, UnknownExtensionAndImpossibleFolderAreNamed) {
  EXPECT_THROW(export_format_of("take.xlsx"), UsageError);
  const test::TemporaryFolder folder;
  write_file(folder.path() / "file", "");
  for (const char* name : {"take.csv", "take.trc", "take.json", "take.npz"}) {
    EXPECT_THROW(export_session(sample_take(), folder.path() / "file" / name), InputError);
  }
  EXPECT_EQ(folder.entry_count(), 1U);
}

}  // namespace
}  // namespace kinemesh::session_formats_test
