#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/c3d/reader.h"
#include "config/input_file.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/npz.h"
#include "tests/support/data.h"
#include "tests/support/samples.h"

namespace kinemesh::test::samples_test {
namespace {

void expect_same(const MarkerSequence& file, const MarkerSequence& made) {
  ASSERT_EQ(file.frame_count(), made.frame_count());
  ASSERT_EQ(file.marker_count(), made.marker_count());
  EXPECT_EQ(file.rate_hz, made.rate_hz);
  for (std::size_t m = 0; m < made.marker_count(); ++m) {
    EXPECT_EQ(file.markers()[m].label, made.markers()[m].label);
    EXPECT_EQ(file.markers()[m].subject, made.markers()[m].subject);
  }
  double worst = 0;
  for (std::size_t f = 0; f < made.frame_count(); ++f) {
    for (std::size_t m = 0; m < made.marker_count(); ++m) {
      ASSERT_EQ(file.valid(f, m), made.valid(f, m)) << "frame " << f << " marker " << m;
      if (!made.valid(f, m)) continue;
      worst = std::max<double>(worst, (file.position(f, m) - made.position(f, m)).norm());
    }
  }
  // Not byte by byte: libm may differ in the last bit between versions.
  EXPECT_LT(worst, 1e-3);
}

TEST(Samples, TheCommittedSessionIsWhatTheGeneratorMakes) {
  const std::string name(sample_with_swap);
  const C3dReadResult file = read_c3d(sample_folder() / (name + ".c3d"));
  const SyntheticTake made = make_sample(name);
  expect_same(file.take, made.measured);
  EXPECT_EQ(file.take.origin.manufacturer, "Kinemesh synthetic");
  ASSERT_EQ(file.take.events.size(), 2U);
  EXPECT_EQ(file.take.events[0].label, "onset");
  EXPECT_NEAR(file.take.events[0].time_s, made.motion.onset_s, 1e-3);
  EXPECT_EQ(file.take.events[1].label, "peak");
  EXPECT_NEAR(file.take.events[1].time_s, made.motion.peak_s, 1e-3);
}

TEST(Samples, AllFourReadWithoutAWarning) {
  for (const std::string& name : sample_names()) {
    const C3dReadResult file = read_c3d(sample_folder() / (name + ".c3d"));
    EXPECT_EQ(file.take.frame_count(), 420U) << name;
    for (const C3dFinding& finding : file.findings) {
      EXPECT_EQ(finding.severity, Severity::info) << name << ": " << finding.message;
    }
  }
}

TEST(Samples, TheTruthBesideThemIsTheGenerators) {
  const std::string name(sample_with_swap);
  const SyntheticTake made = make_sample(name);
  const auto truth = sample_folder() / "truth";
  const NpzFile arrays = read_npz(truth / (name + ".npz"));
  const std::vector<double> positions = npz_array(arrays, "positions").numbers();
  ASSERT_EQ(positions.size(), made.truth.positions().size());
  double worst = 0;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    worst = std::max(worst, std::abs(positions[k] - made.truth.positions()[k]));
  }
  EXPECT_LT(worst, 1e-3);
  const std::vector<double> rotation = npz_array(arrays, "head_rotation").numbers();
  ASSERT_EQ(rotation.size(), 9 * made.head_pose.size());
  EXPECT_NEAR(rotation[9 * 200 + 1], made.head_pose[200].linear()(0, 1), 1e-9);

  const auto json = nlohmann::json::parse(read_file(truth / (name + ".json")));
  EXPECT_TRUE(json.at("synthetic").get<bool>());
  EXPECT_EQ(json.at("gaps").size(), made.gaps.size());
  EXPECT_EQ(json.at("openings").size(), 3U);
  ASSERT_TRUE(made.swap.has_value());
  EXPECT_EQ(json.at("label_swap").at("from_frame").get<std::size_t>(), made.swap->from_frame);

  const Mesh rest = read_mesh(builtin_mesh_formats(), truth / "ben_rest.ply");
  const auto face = sample_face("ben");
  ASSERT_EQ(rest.positions.size(), face->vertex_count());
  for (std::size_t v = 0; v < rest.positions.size(); v += 97) {
    EXPECT_LT((rest.positions[v].cast<double>() - face->rest().positions[v]).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace kinemesh::test::samples_test
