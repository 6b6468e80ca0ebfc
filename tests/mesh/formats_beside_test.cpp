// Files that belong together, numbers of sequences, rates of float times, polygons over frames.
#include <gtest/gtest.h>

#include <algorithm>

#include "config/error.h"
#include "config/output_file.h"
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
  frame("q_2.obj", "1 2", "f 1 2 3 4\nf 1 5 3\n");
  EXPECT_THROW(read_animation(formats, folder.path() / "q_#.obj"), InputError);
}

}  // namespace
}  // namespace kinemesh::formats_beside_test
