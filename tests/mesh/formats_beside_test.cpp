// Files that belong together, numbers of sequences, rates of float times, polygons over frames.
#include <gtest/gtest.h>

#include <algorithm>

#include "config/error.h"
#include "config/output_file.h"
#include "mesh/formats/assumptions.h"
#include "mesh/formats/float_times.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/random_animation.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::formats_beside_test {
namespace {

namespace fs = std::filesystem;
using test::random_animation;
using test::TemporaryFolder;

TEST(FilesBeside, EveryFileThatIsReadIsListed) {
  const FormatRegistry formats = builtin_mesh_formats();
  const AnimatedMesh mesh = random_animation(3, 3, 4);
  for (const char* name : {"a.ply", "b.mdd", "c d.gltf", "e.pvd", "f.npz"}) {
    const TemporaryFolder folder;
    std::vector<fs::path> written = write_animation(formats, mesh, folder.path() / name).files;
    std::vector<fs::path> read = read_animation_file(formats, folder.path() / name).files;
    std::ranges::sort(written);
    std::ranges::sort(read);
    EXPECT_EQ(read, written) << name;
  }
}

TEST(FilesBeside, AnOlderCacheIsMentionedBesideANewMesh) {
  const FormatRegistry formats = builtin_mesh_formats();
  const TemporaryFolder folder;
  AnimatedMesh mesh = random_animation(3, 3, 4);
  mesh.events.clear();
  EXPECT_TRUE(write_animation(formats, mesh, folder.path() / "a.ply").report.notes.empty());
  for (const char* name : {"a.ply", "a.mdd"}) {
    const WriteResult second = write_animation(formats, mesh, folder.path() / name,
                                               {.frames = std::to_string(mesh.first_frame)});
    ASSERT_EQ(second.report.notes.size(), 1U) << name;
    EXPECT_NE(second.report.notes[0].find("the older " + (folder.path() / "a.pc2").string()),
              std::string::npos);
  }
}

TEST(FilesBeside, ExtensionsInCapitalsArePaired) {
  const FormatRegistry formats = builtin_mesh_formats();
  const TemporaryFolder folder;
  write_animation(formats, random_animation(3, 3, 4), folder.path() / "a.ply");
  fs::rename(folder.path() / "a.ply", folder.path() / "a.PLY");
  fs::rename(folder.path() / "a.pc2", folder.path() / "a.PC2");
  for (const char* name : {"a.PLY", "a.PC2"}) {
    const AnimatedMesh back = read_animation(formats, folder.path() / name);
    EXPECT_EQ(back.frame_count(), 4U) << name;
    EXPECT_GT(back.topology().face_count(), 0U) << name;
  }
}

TEST(NumberedFiles, EveryThirtiethFrameKeepsItsNumber) {
  AnimatedMesh mesh = random_animation(3, 3, 100);
  mesh.first_frame = 1;
  const TemporaryFolder folder;
  EXPECT_EQ(write_animation(builtin_mesh_formats(), mesh, folder.path() / "f.obj",
                            {.frames = "10:100:30"})
                .files,
            (std::vector{folder.path() / "f_0010.obj", folder.path() / "f_0040.obj",
                         folder.path() / "f_0070.obj", folder.path() / "f_0100.obj"}));
}

TEST(FloatTimes, RatesOfVideoAreNotRoundedToWholeOnes) {
  for (const double rate : {24.0, 25.0, 120.0, 59.94, 29.97, 23.976, 119.88}) {
    const auto last = static_cast<float>(419 / rate);
    EXPECT_EQ(rate_from_float_times(0, last, 419), rate);
  }
  // Two frames late in a take: the times cannot tell 60 from 59.99.
  EXPECT_EQ(rate_from_float_times(double{static_cast<float>(100.0)},
                                  double{static_cast<float>(100.0 + 1.0 / 60)}, 1),
            60.0);
  EXPECT_EQ(rate_from_float_times(1, 1, 5), 0.0);
}

TEST(Polygons, AreOneTopologyHoweverEachFrameCutsThem) {
  const FormatRegistry formats = builtin_mesh_formats();
  const TemporaryFolder folder;
  const std::string faces = "f 1 2 3 4\nf 2 5 3\n";
  const auto frame = [&](const std::string& name, const std::string& corner,
                         const std::string& rest) {
    write_file(folder.path() / name,
               "v 0 0 0\nv " + corner + " 0\nv 4 4 0\nv 0 4 0\nv 8 0 0\n" + rest);
  };
  frame("q_1.obj", "4 0", faces);
  frame("q_2.obj", "1 2", faces);  // the second corner points inwards
  const AnimatedMesh mesh = read_animation(formats, folder.path() / "q_#.obj");
  EXPECT_EQ(mesh.frame_count(), 2U);
  EXPECT_EQ(mesh.topology().faces(), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}));
  const MeshSequence frames = read_mesh_sequence(formats, folder.path() / "q_#.obj");
  EXPECT_EQ(frames.frames[0].topology, frames.frames[1].topology);
  frame("q_2.obj", "1 2", "f 1 2 3 4\nf 1 5 3\n");
  EXPECT_THROW(read_animation(formats, folder.path() / "q_#.obj"), InputError);
}

TEST(Rates, OfAPvdThatOnlyNumbersItsFilesIsNotKnown) {
  const FormatRegistry formats = builtin_mesh_formats();
  const TemporaryFolder folder;
  AnimatedMesh mesh = random_animation(3, 3, 4);
  mesh.events.clear();
  mesh.rate_hz = 0;
  write_animation(formats, mesh, folder.path() / "a.pvd");
  EXPECT_EQ(read_animation(formats, folder.path() / "a.pvd").rate_hz, 0.0);
  EXPECT_EQ(read_animation(formats, folder.path() / "a.pvd", {.rate_hz = 50}).rate_hz, 50.0);
  mesh.rate_hz = 1;  // a rate that looks like numbering is stated beside it
  write_animation(formats, mesh, folder.path() / "a.pvd");
  EXPECT_EQ(read_animation(formats, folder.path() / "a.pvd").rate_hz, 1.0);
}

TEST(Units, AFileOfASequenceThatDoesNotSayItsUnitHasThatOfTheFirst) {
  const FormatRegistry formats = builtin_mesh_formats();
  const TemporaryFolder folder;
  write_file(folder.path() / "a_1.obj", "# kinemesh unit \"cm\"\nv 1 2 3\n");
  write_file(folder.path() / "a_2.obj", "v 4 5 6\n");
  const AnimatedMesh mesh = read_animation(formats, folder.path() / "a_#.obj");
  EXPECT_EQ(mesh.position(0, 0), Eigen::Vector3f(10, 20, 30));
  EXPECT_EQ(mesh.position(1, 0), Eigen::Vector3f(40, 50, 60));
}

TEST(Assumptions, AreSaidWhereTheFileSaysNothingOrSomethingElse) {
  AnimationFile file{.mesh = random_animation(3, 3, 4)};
  file.mesh.rate_hz = 0;
  EXPECT_EQ(assumptions_of(file, "a.obj", {}),
            (std::vector<std::string>{
                "a.obj does not say its unit: taken as mm (--unit says otherwise)",
                "a.obj does not say its frame rate: left unknown (--rate gives one)"}));
  file.mesh.rate_hz = 120;
  EXPECT_TRUE(assumptions_of(file, "a.obj", {.unit = LengthUnit::m, .rate_hz = 120}).empty());
  file.unit = LengthUnit::mm;
  EXPECT_EQ(
      assumptions_of(file, "a.obj", {.unit = LengthUnit::m, .rate_hz = 50}),
      (std::vector<std::string>{"a.obj says that its unit is mm: --unit m is not used",
                                "a.obj says that its rate is 120 Hz: --rate 50 is not used"}));
}

TEST(Options, OfGltfWithoutEffectAreSaid) {
  const FormatRegistry formats = builtin_mesh_formats();
  const TemporaryFolder folder;
  AnimatedMesh mesh = random_animation(3, 3, 4);
  mesh.events.clear();
  WriteOptions options;
  options.gltf.colour = VertexColour::deformation;
  options.gltf.up = GltfUp::y;  // that of a session
  EXPECT_EQ(write_animation(formats, mesh, folder.path() / "a.ply", options).report.notes,
            std::vector<std::string>{"--colour is for glTF: without effect on ply+pc2"});
  for (const std::string& note :
       write_animation(formats, mesh, folder.path() / "a.glb", options).report.notes) {
    EXPECT_EQ(note.find("without effect"), std::string::npos);
  }
}

}  // namespace
}  // namespace kinemesh::formats_beside_test
