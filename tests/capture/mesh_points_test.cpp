// Meshes as recordings of markers: files without a rate, odd names, what is said about losses.
#include <gtest/gtest.h>

#include "capture/formats/mesh_formats.h"
#include "config/error.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/random_animation.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::mesh_points_test {
namespace {

AnimatedMesh points_without_rate() {
  AnimatedMesh mesh = test::random_animation(3, 3, 5);
  mesh.rate_hz = 0.0;
  mesh.first_frame = 1;
  mesh.events.clear();
  return mesh;
}

TEST(MeshPoints, FilesWithoutARateTakeTheOneThatIsTold) {
  const AnimatedMesh mesh = points_without_rate();
  const FormatRegistry formats = all_formats();
  const test::TemporaryFolder folder;
  for (const char* name : {"a.csv", "a.trc", "a.c3d"}) {
    write_animation(formats, mesh, folder.path() / name);
    const AnimatedMesh back = read_animation(formats, folder.path() / name, {.rate_hz = 50.0});
    EXPECT_EQ(back.rate_hz, 50.0) << name;
    EXPECT_EQ(back.frame_count(), 5U) << name;
  }
}

TEST(MeshPoints, NamesMayHoldEverySeparator) {
  AnimatedMesh mesh = test::random_animation(3, 3, 5);
  mesh.vertex_names = {"a;b", "c\td", "e,f", "g", "h\"i", "j k", ";", "l", "m;\t,n"};
  const FormatRegistry formats = all_formats();
  const test::TemporaryFolder folder;
  write_animation(formats, mesh, folder.path() / "a.csv");
  EXPECT_EQ(read_animation(formats, folder.path() / "a.csv").vertex_names, mesh.vertex_names);
}

TEST(MeshPoints, FirstFrameAndOriginAreSaid) {
  AnimatedMesh mesh = test::random_animation(3, 3, 5);
  mesh.first_frame = -5;
  mesh.position(2, 4).setZero();
  const FormatRegistry formats = all_formats();
  const test::TemporaryFolder folder;
  const auto said = [&](const char* name, const std::string& part) {
    const auto notes = write_animation(formats, mesh, folder.path() / name).report.notes;
    return std::ranges::any_of(
        notes, [&part](const std::string& note) { return note.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(said("a.c3d", "the first frame is -5"));
  EXPECT_TRUE(said("a.c3d", "1 sample at exactly (0, 0, 0)"));
  EXPECT_TRUE(said("a.trc", "1 sample at exactly (0, 0, 0)"));
  EXPECT_FALSE(said("a.csv", "(0, 0, 0)"));
}

}  // namespace
}  // namespace kinemesh::mesh_points_test
