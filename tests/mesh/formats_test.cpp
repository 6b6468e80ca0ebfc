// Every format that holds an animation or a numbered sequence gives back what was written.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/random_animation.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::formats_test {
namespace {

using test::random_animation;
using test::TemporaryFolder;

const FormatRegistry& formats() {
  static const FormatRegistry registry = builtin_mesh_formats();
  return registry;
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

/// An output, what to give the reader, and how it is encoded.
struct Case {
  std::string write, read;
  Encoding encoding = Encoding::binary;
  std::string format{};
};

class RoundTrip : public testing::TestWithParam<Case> {};

TEST_P(RoundTrip, GivesBackWhatTheFormatKeeps) {
  const AnimatedMesh mesh = random_animation(5, 4, 7);
  const TemporaryFolder folder;
  const Case& c = GetParam();
  const WriteResult result = write_animation(formats(), mesh, folder.path() / c.write,
                                             {.format = c.format, .encoding = c.encoding});
  const AnimatedMesh back = read_animation(formats(), folder.path() / c.read);
  test::expect_same_positions(mesh, back);
  test::expect_same_description(mesh, back);
  const Keeps& keeps = formats().find(result.format)->keeps;
  const auto lost = [&result](const char* what) {
    return std::ranges::count(result.report.lost, what) == 1;
  };
  EXPECT_NE(lost("filled flags"), keeps.filled);
  EXPECT_NE(lost("uncertainty"), keeps.uncertainty);
  const auto same = [](auto a, auto b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  };
  EXPECT_EQ(same(mesh.filled(), back.filled()), keeps.filled);
  EXPECT_EQ(same(mesh.uncertainty(), back.uncertainty()), keeps.uncertainty);
}

INSTANTIATE_TEST_SUITE_P(
    Formats, RoundTrip,
    testing::Values(Case{"a.ply", "a.ply"}, Case{"a.pc2", "a.ply"}, Case{"a.ply", "a.pc2"},
                    Case{"a.ply", "a.ply", Encoding::ascii},
                    Case{"a.ply", "a.pc2", Encoding::binary_big}, Case{"a.mdd", "a.mdd"},
                    Case{"a.mdd", "a.ply"}, Case{"a_####.ply", "a_####.ply"},
                    Case{"a_####.ply", "a_%04d.ply", Encoding::ascii},
                    Case{"new/folder/a_####.ply", "new/folder", Encoding::binary_big},
                    Case{"a.obj", "a_####.obj"}, Case{"b_##.obj", "b_#.obj"},
                    Case{"frames/", "frames", Encoding::binary, "ply-sequence"},
                    Case{"frames", "frames", Encoding::binary, "obj"}, Case{"a.off", "a_####.off"},
                    Case{"a.pvd", "a.pvd"}, Case{"a.pvd", "a_frames", Encoding::ascii},
                    Case{"a_####.vtp", "a_####.vtp", Encoding::binary_big},
                    Case{"a.npz", "a.npz"}));

/// VTK's reader of PLY gives up at a line of 4,096 bytes, RPly at 1,024.
TEST(Formats, LongDescriptionsAreCutIntoLinesThatOtherReadersTake) {
  AnimatedMesh mesh = random_animation(3, 3, 600);
  if (mesh.filled().empty()) mesh.add_filled();
  for (std::size_t i = 0; i < mesh.filled().size(); ++i) mesh.filled()[i] = i / 3 % 2;
  mesh.provenance.command.clear();
  for (int i = 0; i < 3000; ++i) mesh.provenance.command += i % 7 == 0 ? "\u00e4" : "\"";
  mesh.provenance.options.clear();
  for (int i = 0; i < 400; ++i) {
    mesh.provenance.options += "# option " + std::to_string(i) + "\nvalue = \"\u00e4\"\n";
  }
  const TemporaryFolder folder;
  write_animation(formats(), mesh, folder.path() / "a.ply", {});
  const std::string ply = read_file(folder.path() / "a.ply");
  std::istringstream header(ply.substr(0, ply.find("end_header")));
  for (std::string line; std::getline(header, line);) EXPECT_LT(line.size(), 1000U);
  const AnimatedMesh back = read_animation(formats(), folder.path() / "a.ply");
  test::expect_same_description(mesh, back);
  EXPECT_EQ(back.provenance.command, mesh.provenance.command);
  EXPECT_EQ(back.provenance.options, mesh.provenance.options);
  EXPECT_TRUE(std::ranges::equal(back.filled(), mesh.filled()));
}

TEST(Formats, SequencesAreNumberedByTheTakesFrames) {
  const AnimatedMesh mesh = random_animation(3, 3, 3);
  const TemporaryFolder folder;
  EXPECT_EQ(write_animation(formats(), mesh, folder.path() / "a.obj").files.front(),
            folder.path() / "a_1207.obj");
  EXPECT_EQ(write_animation(formats(), mesh, folder.path() / "b_######.ply",
                            {.frames = "1207:1209:2", .first_number = 0})
                .files,
            (std::vector{folder.path() / "b_000000.ply", folder.path() / "b_000001.ply"}));
}

TEST(Formats, EveryTenthFrameKeepsTheTimeOfFramesAndEvents) {
  AnimatedMesh mesh = random_animation(3, 3, 101);
  mesh.rate_hz = 120.0;
  mesh.first_frame = 1;
  mesh.events = {{.label = "start", .time_s = 0.1}, {.label = "peak", .time_s = 0.7}};
  const TemporaryFolder folder;
  const WriteResult written =
      write_animation(formats(), mesh, folder.path() / "m.ply", {.frames = "50:100:10"});
  EXPECT_EQ(written.report.notes,
            std::vector<std::string>{"1 event outside the frames written left out"});
  const AnimatedMesh back = read_animation(formats(), folder.path() / "m.ply");
  ASSERT_EQ(back.frame_count(), 6U);
  EXPECT_EQ(back.rate_hz, 12.0);
  ASSERT_EQ(back.events.size(), 1U);
  EXPECT_EQ(back.events[0].label, "peak");
  // Frame 50 is at 49 / 120 s, and the event 35 / 120 s after it.
  const double first_s = static_cast<double>(back.first_frame - 1) / 12.0;
  EXPECT_NEAR(back.events[0].time_s - first_s, 35.0 / 120.0, 1e-9);
}

TEST(Formats, OneFrameIsOneFile) {
  const AnimatedMesh mesh = random_animation(3, 3, 3);
  const TemporaryFolder folder;
  const WriteResult result =
      write_animation(formats(), mesh, folder.path() / "one.ply", {.frames = "1208"});
  EXPECT_EQ(result.files, std::vector{folder.path() / "one.ply"});
  const AnimatedMesh back = read_animation(formats(), folder.path() / "one.ply");
  ASSERT_EQ(back.frame_count(), 1U);
  EXPECT_EQ(back.first_frame, 1208);
  for (VertexIndex v = 0; v < 9; ++v) EXPECT_EQ(back.position(0, v), mesh.position(1, v));
}

TEST(Formats, UnitsAreConvertedAndAskedFor) {
  const AnimatedMesh mesh = test::smooth_animation(4, 4, 2, 60.0);
  const TemporaryFolder folder;
  write_animation(formats(), mesh, folder.path() / "m.ply", {.unit = LengthUnit::m});
  const AnimatedMesh said =
      read_animation(formats(), folder.path() / "m.ply", {.unit = LengthUnit::foot});
  EXPECT_NEAR(said.position(1, 5).x(), mesh.position(1, 5).x(), 1e-5);
  write_file(folder.path() / "unknown.obj", "v 1 2 3\nv 0 0 0\nv 1 0 0\nf 1 2 3\n");
  const AnimatedMesh cm = read_animation(formats(), folder.path() / "unknown.obj",
                                         {.unit = LengthUnit::cm, .rate_hz = 25});
  EXPECT_EQ(cm.position(0, 0), Eigen::Vector3f(10, 20, 30));
  EXPECT_EQ(cm.rate_hz, 25.0);
}

TEST(Formats, DifferingTopologyIsASequenceButNoAnimation) {
  const TemporaryFolder folder;
  MeshSequence sequence;
  sequence.rate_hz = 30;
  for (const uint32_t size : {3U, 4U, 4U, 5U}) {
    sequence.frames.push_back(random_animation(size, 3, 1).mesh_at(0));
  }
  write_mesh_sequence(formats(), sequence, folder.path() / "s_####.ply");
  const MeshSequence back = read_mesh_sequence(formats(), folder.path());
  ASSERT_EQ(back.frames.size(), 4U);
  EXPECT_EQ(back.rate_hz, 30.0);
  for (std::size_t f = 0; f < 4; ++f) {
    EXPECT_EQ(back.frames[f].positions, sequence.frames[f].positions);
    EXPECT_EQ(*back.frames[f].topology, *sequence.frames[f].topology);
  }
  EXPECT_EQ(back.frames[1].topology, back.frames[2].topology);  // shared
  EXPECT_EQ(message_of([&] { read_animation(formats(), folder.path()); }),
            (folder.path() / "s_0002.ply").string() +
                ": it has 12 vertices, the first file 9. An animated mesh has one topology in all "
                "frames");
}

TEST(Formats, WrongPathsAndFormatsAreExplained) {
  const AnimatedMesh mesh = random_animation(3, 3, 2);
  const TemporaryFolder folder;
  const auto writing = [&](const std::string& name, const std::string& format) {
    return message_of(
        [&] { write_animation(formats(), mesh, folder.path() / name, {.format = format}); });
  };
  EXPECT_NE(writing("a.xyz", "").find("no writer for files named like 'a.xyz'"), std::string::npos);
  EXPECT_NE(writing("a.ply", "objj").find("Did you mean 'obj'?"), std::string::npos);
  EXPECT_NE(writing("a.obj", "ply").find("End it with .ply"), std::string::npos);
  EXPECT_EQ(folder.entry_count(), 0U);
  write_file(folder.path() / "file", "");
  EXPECT_NE(writing("file/a.pc2", "").find("cannot create the folder"), std::string::npos);
  const auto reading = [&](const std::string& name) {
    return message_of([&] { read_animation(formats(), folder.path() / name); });
  };
  EXPECT_NE(reading("none.ply").find("No such file"), std::string::npos);
  EXPECT_NE(reading("a.xyz").find("no reader for files named *.xyz"), std::string::npos);
  EXPECT_NE(reading("a_##.ply").find("no file matches"), std::string::npos);
  EXPECT_NE(reading("").find("holds no numbered mesh files"), std::string::npos);
  EXPECT_THROW(write_animation(formats(), mesh, folder.path() / "a.ply", {.frames = "1:2"}),
               UsageError);
  EXPECT_THROW(write_animation(formats(), mesh, folder.path() / "a.ply", {.frames = "x"}),
               UsageError);
}

TEST(Formats, OlderFilesOfASequenceAreMentioned) {
  const TemporaryFolder folder;
  write_animation(formats(), random_animation(3, 3, 5), folder.path() / "a_####.obj",
                  {.first_number = 1});
  const WriteResult second = write_animation(formats(), random_animation(3, 3, 2),
                                             folder.path() / "a_####.obj", {.first_number = 1});
  ASSERT_EQ(second.report.notes.size(), 1U);
  EXPECT_NE(second.report.notes[0].find("3 older files"), std::string::npos);
}

TEST(Formats, PositionsThatAreNoNumbersAreRefused) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& name, const std::string& text) {
    const std::filesystem::path path = folder.path() / name;
    write_file(path, text);
    return message_of([&] { read_animation(formats(), path); }).substr(path.string().size());
  };
  EXPECT_EQ(message("a.obj", "v 1 2 3\nv 0 nan 0\nv 1 0 0\nf 1 2 3\n"),
            ": line 2: a coordinate is not a finite number. Fill the gap, or leave the vertex out");
  EXPECT_EQ(message("a.off", "OFF\n3 1 0\n1 2 3\n0 0 0\n1 inf 0\n3 0 1 2\n"),
            ": line 5: a coordinate is not a finite number. Fill the gap, or leave the vertex out");
  EXPECT_EQ(message("a.ply",
                    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                    "property float z\nend_header\n1 2 3\n0 nan 0\n"),
            ": vertex 1 (0-based): the position is not a finite number. Fill the gap, or leave the "
            "vertex out");
  EXPECT_EQ(message("a.vtp",
                    "<VTKFile type=\"PolyData\"><PolyData><Piece><Points><DataArray "
                    "type=\"Float32\" format=\"ascii\">0 0 0 1</DataArray></Points></Piece>"
                    "</PolyData></VTKFile>"),
            ": byte 91: the number of coordinates is no multiple of three");
}

}  // namespace
}  // namespace kinemesh::formats_test
