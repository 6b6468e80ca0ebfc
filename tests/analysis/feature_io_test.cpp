// Files of features: round trips, and malformed ones.
#include "analysis/feature_io.h"

#include <gtest/gtest.h>

#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::feature_io_test {
namespace {

using test::TemporaryFolder;

FeatureSet sample_set() {
  FeatureSet set{"walk \"1\".ply", 100, 3, 59.94, 512.25, {}};
  Feature f{.vertex = 99, .frame = 2, .time_s = 1.0 / 3, .sigma_mm = 0.1, .tau_s = 1e-9};
  f.response = -1e-20;
  f.descriptor.displacement = {0.1F, 1.0F};
  f.descriptor.deformation = {0.0F, 1e-7F, 0.3F};
  f.descriptor.histogram.assign(256, 1.0F / 256);
  set.features = {f, {.vertex = 0, .kind = FeatureKind::displacement}};
  return set;
}

TEST(FeatureIo, JsonKeepsEveryNumber) {
  const TemporaryFolder folder;
  const FeatureSet set = sample_set();
  write_features(folder.path() / "f.json", set);
  const FeatureSet back = read_features(folder.path() / "f.json");
  EXPECT_EQ(back.animation, set.animation);
  EXPECT_EQ(back.vertex_count, 100U);
  EXPECT_EQ(back.rate_hz, set.rate_hz);
  ASSERT_EQ(back.features.size(), 2U);
  EXPECT_EQ(back.features[0].time_s, set.features[0].time_s);
  EXPECT_EQ(back.features[0].response, set.features[0].response);
  EXPECT_EQ(back.features[0].descriptor.deformation, set.features[0].descriptor.deformation);
  EXPECT_EQ(back.features[0].descriptor.histogram, set.features[0].descriptor.histogram);
  EXPECT_EQ(back.features[1].kind, FeatureKind::displacement);
  EXPECT_TRUE(back.features[1].descriptor.displacement.empty());
  EXPECT_EQ(features_json(back), features_json(set));
}

TEST(FeatureIo, CsvHasOneLineAFeature) {
  const TemporaryFolder folder;
  write_features(folder.path() / "f.csv", sample_set());
  const std::string text = read_file(folder.path() / "f.csv");
  EXPECT_NE(text.find("\n99,2,0.3333333333333333,0.1,1e-09,-1e-20,deformation\n"),
            std::string::npos)
      << text;
}

TEST(FeatureIo, MalformedFilesAreRefusedWithTheirPlace) {
  const TemporaryFolder folder;
  const std::string good = features_json(sample_set());
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
  };
  const std::vector<std::string> bad = {
      "",
      "{",
      "[]",
      "{\"format\": \"kinemesh features\"}",
      with("\"vertex\": 99", "\"vertex\": 100"),
      with("\"vertex\": 99", "\"vertex\": -1"),
      with("\"vertex\": 99", "\"vertex\": 1e400"),
      with("\"frame\": 2", "\"frame\": 2.5"),
      with("\"frames\": 3", "\"frames\": 0"),
      with("\"frames\": 3", "\"frames\": 4"),
      with("\"kind\": \"deformation\"", "\"kind\": \"other\""),
      with("[0.1, 1]", "[0.1]"),
      with("[0.1, 1]", "[0.1, null]"),
      with("\"vertices\": 100", "\"vertices\": 1e18"),
      with("\"sigma_mm\": 0.1", "\"sigma_mm\": \"x\""),
  };
  for (const std::string& text : bad) {
    write_file(folder.path() / "bad.json", text);
    try {
      read_features(folder.path() / "bad.json");
      ADD_FAILURE() << "accepted: " << text.substr(0, 200);
    } catch (const InputError& error) {
      EXPECT_EQ(error.details().file, (folder.path() / "bad.json").string());
    }
  }
  EXPECT_THROW(read_features(folder.path() / "missing.json"), InputError);
}

}  // namespace
}  // namespace kinemesh::feature_io_test
