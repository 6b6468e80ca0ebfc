// Real files of other programs.
#include <gtest/gtest.h>

#include "mesh/formats/mesh_io.h"
#include "mesh/mesh_info.h"
#include "tests/support/data.h"
#include "tests/support/random_animation.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::formats_data_test {
namespace {

const FormatRegistry& formats() {
  static const FormatRegistry registry = builtin_mesh_formats();
  return registry;
}

TEST(RealFiles, HorseGallopRoundTrips) {
  KINEMESH_NEED_DATA("anim/horse_gallop.ply");
  const AnimatedMesh horse =
      read_animation(formats(), test::data_folder() / "anim/horse_gallop.ply",
                     {.unit = LengthUnit::m, .rate_hz = 24});
  EXPECT_EQ(horse.vertex_count(), 8431U);
  EXPECT_EQ(horse.frame_count(), 48U);
  EXPECT_EQ(horse.topology().face_count(), 16843U);
  const test::TemporaryFolder folder;
  for (const char* name : {"a.ply", "b.mdd", "c.pvd", "d.npz"}) {
    write_animation(formats(), horse, folder.path() / name);
    const AnimatedMesh back = read_animation(formats(), folder.path() / name);
    test::expect_same_positions(horse, back);
    EXPECT_EQ(back.topology(), horse.topology());
    EXPECT_EQ(back.rate_hz, 24.0);
  }
}

TEST(RealFiles, SequenceOfDifferingTopology) {
  KINEMESH_NEED_DATA("changing_pent");
  const MeshSequence sequence =
      read_mesh_sequence(formats(), test::data_folder() / "changing_pent");
  ASSERT_EQ(sequence.frames.size(), 50U);
  EXPECT_EQ(sequence.frames[0].positions.size(), 1922U);
  EXPECT_EQ(sequence.frames[1].positions.size(), 1836U);
}

TEST(RealFiles, ToscaCats) {
  KINEMESH_NEED_DATA("tosca_cat/cat0.off");
  const AnimatedMesh cat = read_animation(formats(), test::data_folder() / "tosca_cat/cat0.off");
  const MeshInfo info = mesh_info_of(cat);
  EXPECT_EQ(info.vertices, 5000U);
  EXPECT_EQ(info.faces, 9996U);
  EXPECT_TRUE(info.manifold);
  EXPECT_EQ(info.genus, 0);
  EXPECT_NEAR(cat.position(0, 0).x(), 1.75323224F, 1e-6);
}

TEST(RealFiles, IctFaceIsOpenAndInCentimetres) {
  KINEMESH_NEED_DATA("face_ict/neutral.ply");
  const AnimatedMesh face = read_animation(formats(), test::data_folder() / "face_ict/neutral.ply",
                                           {.unit = LengthUnit::cm});
  const MeshInfo info = mesh_info_of(face);
  EXPECT_EQ(info.vertices, 9409U);
  EXPECT_FALSE(info.boundaries.empty());
  EXPECT_NEAR((info.high - info.low).y(), 300.0, 100.0);  // the height of a head, mm
}

}  // namespace
}  // namespace kinemesh::formats_data_test
