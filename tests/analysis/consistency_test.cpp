// Agreement of features with a true map: by construction, and on the face model.
#include "analysis/feature_consistency.h"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/anim_dog.h"
#include "analysis/marked_regions.h"
#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/data.h"
#include "tests/support/deforming_shapes.h"
#include "tests/support/ict_performer.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::consistency_test {
namespace {

Mesh mesh_of(const test::Sheet& sheet) {
  Mesh mesh{sheet.topology, {}, {}};
  for (const auto& p : sheet.positions) mesh.positions.push_back(p.cast<float>());
  return mesh;
}

SurfaceMap identity_map(const Topology& topology) {
  SurfaceMap map;
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    const FaceIndex face = topology.faces_of(v)[0];
    SurfacePoint point{face, {}};
    for (std::size_t c = 0; c < 3; ++c) point.weights[c] = topology.faces()[face][c] == v ? 1 : 0;
    map.points.push_back(point);
  }
  return map;
}

TEST(Consistency, CountsPairsOneToOneInSpaceAndTime) {
  const auto sheet = test::make_sheet(100, 100, 5, 1);
  const Mesh mesh = mesh_of(sheet);
  const SurfaceMap map = identity_map(*sheet.topology);
  FeatureSet a{"", sheet.positions.size(), 100, 50, 0, {}};
  FeatureSet b = a;
  // The same four places; the second at another time, the third far away, two of b at one place.
  a.features = {{.vertex = 22, .frame = 10},
                {.vertex = 180, .frame = 10},
                {.vertex = 60, .frame = 50},
                {.vertex = 400, .frame = 80}};
  b.features = {{.vertex = 22, .frame = 12},
                {.vertex = 180, .frame = 40},
                {.vertex = 300, .frame = 50},
                {.vertex = 22, .frame = 11}};
  const auto result = feature_consistency(a, b, map, mesh);
  EXPECT_EQ(result.features.strict, 0.25);
  EXPECT_EQ(result.features.nearest, (2.0 + 3.0) / 8.0);
  const auto same = feature_consistency(a, a, map, mesh);
  EXPECT_EQ(same.features.strict, 1.0);
  EXPECT_EQ(same.features.slack, 1.0);
  EXPECT_EQ(same.features.nearest, 1.0);
  EXPECT_LT(same.shuffled.strict, 1.0);
  EXPECT_LT(same.random.strict, 0.3);
  FeatureSet wrong = a;
  wrong.vertex_count = 7;
  EXPECT_THROW(feature_consistency(wrong, b, map, mesh), InputError);
}

TEST(Consistency, MarkedRegionsGivePrecisionAndRecall) {
  const auto sheet = test::make_sheet(100, 100, 5, 2);
  const Mesh mesh = mesh_of(sheet);
  FeatureSet set{"", sheet.positions.size(), 10, 30, 0, {}};
  set.features = {{.vertex = 220, .frame = 1, .sigma_mm = 20}};
  const auto covered = feature_coverage(set, mesh);
  std::string list = "[";
  for (std::size_t v = 0; v < covered.size(); ++v) {
    if (covered[v] > 0) list += std::to_string(v) + ",";
  }
  list.back() = ']';
  const test::TemporaryFolder folder;
  write_file(folder.path() / "a.json", "{\"regions\": [" + list + "]}");
  write_file(folder.path() / "b.json", "[0, 1, 2]");
  const auto marked =
      read_marked_regions({folder.path() / "a.json", folder.path() / "b.json"}, covered.size());
  EXPECT_EQ(marked[0], 0.5);
  EXPECT_EQ(marked[220], 0.5);
  const std::vector<double> thresholds{0.0, 0.5};
  const auto scores = compare_regions(set, mesh, marked, thresholds);
  EXPECT_EQ(scores[0].precision, 1.0);
  EXPECT_GT(scores[0].recall, 0.95);
  EXPECT_LT(scores[0].recall, 1.0);
  EXPECT_EQ(scores[1].recall, 0.0);
  // A PLY with colours.
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nend_header\n"
      "0 200 200 200\n1.5 255 0 0\n2 9 9 9\n";
  write_file(folder.path() / "c.ply", ply);
  EXPECT_EQ(read_marked_regions({folder.path() / "c.ply"}, 3), (std::vector<double>{0, 1, 0}));
  EXPECT_THROW(read_marked_regions({folder.path() / "c.ply"}, 4), InputError);
  EXPECT_THROW(read_marked_regions({folder.path() / "b.json"}, 2), InputError);
  write_file(folder.path() / "d.json", "[[[");
  EXPECT_THROW(read_marked_regions({folder.path() / "d.json"}, 2), InputError);
}

TEST(Consistency, TwoFacesDoingTheSameAgree) {
  KINEMESH_NEED_DATA("face_ict/neutral.ply");
  const test::IctModel& model = test::ict_model();
  const auto motion = test::make_ict_motion(model, 2);
  test::PerformOptions options;
  options.rate_hz = 30;
  const auto a = test::perform(model, {.seed = 501}, motion, options);
  const auto b = test::perform(model, {.seed = 502}, motion, options);
  const auto fa = detect_features(a.mesh, deformation_of(a.mesh));
  const auto fb = detect_features(b.mesh, deformation_of(b.mesh));
  ASSERT_GE(fa.set.features.size(), 20U);
  const auto result =
      feature_consistency(fa.set, fb.set, test::true_map(model, a, b), b.mesh.mesh_at(0));
  EXPECT_GE(result.features.strict, 0.6);
  EXPECT_GT(result.features.strict, result.shuffled.strict + 0.2);
  EXPECT_GT(result.features.strict, result.random.strict + 0.4);
}

}  // namespace
}  // namespace kinemesh::consistency_test
