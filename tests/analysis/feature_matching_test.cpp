// Matching features whose partners are known.
#include "analysis/feature_matching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/feature_matching_io.h"
#include "config/error.h"
#include "config/input_file.h"
#include "tests/support/bending_cylinder.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::feature_matching_test {
namespace {

/// A bump on the cylinder that swells and goes, at (angle, part of the length).
struct Bump {
  double angle, along, time, height;
};

struct Subject {
  AnimatedMesh mesh;
  FeatureSet features;
};

double angle_between(double a, double b) { return std::remainder(a - b, 2.0 * std::numbers::pi); }

/// A cylinder, symmetric under angle → −angle, with one feature per bump in their order.
Subject make_subject(const test::CylinderShape& shape, const std::vector<Bump>& bumps) {
  const test::BendingCylinder cylinder = make_bending_cylinder(shape);
  Subject s{.mesh = AnimatedMesh(cylinder.mesh.shared_topology(), 30, 30.0), .features = {}};
  for (std::size_t f = 0; f < 30; ++f) {
    for (std::size_t v = 0; v < cylinder.parameters.size(); ++v) {
      const auto [angle, along] = cylinder.parameters[v];
      Eigen::Vector3d p = cylinder.rest_place({angle, along});
      for (const Bump& b : bumps) {
        const double here = std::exp(-std::pow(angle_between(angle, b.angle) / 0.35, 2) -
                                     std::pow((along - b.along) / 0.06, 2));
        const double now = std::exp(-std::pow((static_cast<double>(f) / 29.0 - b.time) / 0.08, 2));
        p += b.height * here * now * Eigen::Vector3d(0.0, std::cos(angle), std::sin(angle));
      }
      s.mesh.position(f, static_cast<VertexIndex>(v)) = p.cast<float>();
    }
  }
  s.features.animation = "made";
  s.features.vertex_count = s.mesh.vertex_count();
  s.features.frame_count = 30;
  s.features.rate_hz = 30.0;
  for (const Bump& b : bumps) {
    VertexIndex best = 0;
    double least = 1e9;
    for (std::size_t v = 0; v < cylinder.parameters.size(); ++v) {
      const auto [angle, along] = cylinder.parameters[v];
      const double d = std::abs(angle_between(angle, b.angle)) + 10.0 * std::abs(along - b.along);
      if (d < least) {
        least = d;
        best = static_cast<VertexIndex>(v);
      }
    }
    const auto frame = static_cast<uint32_t>(std::lround(29.0 * b.time));
    s.features.features.push_back(
        {.vertex = best, .frame = frame, .time_s = frame / 30.0, .sigma_mm = 5, .tau_s = 0.1});
  }
  return s;
}

const test::CylinderShape slim{},
    stout{.length_mm = 190, .radius_mm = 23, .around = 30, .along = 70};

const std::vector<Bump> left_side = {{0.5, 0.15, 0.2, 4},
                                     {1.2, 0.35, 0.35, 3},
                                     {1.9, 0.5, 0.5, 5},
                                     {0.9, 0.65, 0.65, 4},
                                     {1.6, 0.85, 0.8, 3}};

std::vector<Bump> with_mirror_image(const std::vector<Bump>& bumps, double height_factor) {
  std::vector<Bump> both = bumps;
  for (Bump b : bumps) {
    b.angle = -b.angle;
    b.height *= height_factor;
    both.push_back(b);
  }
  return both;
}

FeatureMatching match(const Subject& a, const Subject& b,
                      const FeatureMatchingOptions& options = {}) {
  return match_features(feature_places(a.features, a.mesh, options),
                        feature_places(b.features, b.mesh, options), options, {.gap = 5e-4});
}

void expect_identity(const FeatureMatching& m, std::size_t count) {
  EXPECT_EQ(m.matches.size(), count);
  for (const FeatureMatch& match : m.matches) EXPECT_EQ(match.source, match.target);
  EXPECT_TRUE(m.solution.certified);
}

TEST(FeatureMatching, ASubjectMatchesItself) {
  const Subject a = make_subject(slim, left_side);
  const FeatureMatching m = match(a, a);
  expect_identity(m, left_side.size());
  for (const FeatureMatch& k : m.matches) {
    EXPECT_NEAR(k.descriptor, 0.0, 1e-9);
    EXPECT_NEAR(k.geodesic, 0.0, 1e-9);
    EXPECT_GT(k.margin, 0.0);
    EXPECT_LE(k.margin, -k.energy + 1e-12);  // staying unmatched is one of the others
  }
  EXPECT_NEAR(m.terms.coherence, 0.0, 1e-9);
  EXPECT_NEAR(m.terms.unmatched_part, 0.0, 1e-9);
}

TEST(FeatureMatching, TheTermsAddUpToTheEnergy) {
  const Subject a = make_subject(slim, left_side);
  Subject b = make_subject(stout, left_side);
  b.features.features.pop_back();
  for (const GeodesicPrior prior : {GeodesicPrior::none, GeodesicPrior::printed}) {
    const int neighbours = prior == GeodesicPrior::none ? 0 : 2;
    const FeatureMatching m =
        match(a, b, {.neighbours = neighbours, .reject = 1e-6, .prior = prior});
    // The terms are those of the whole solution.
    EXPECT_TRUE(prior == GeodesicPrior::printed || !m.rejected.empty());
    EXPECT_GT(m.terms.geodesic, 0.0);
    EXPECT_GE(m.terms.coherence, 0.0);
    const double sum = m.terms.descriptor + m.terms.geodesic + m.terms.orientation + m.terms.prior +
                       m.terms.unmatched_part + m.terms.coherence;
    EXPECT_NEAR(4.0 * sum, m.solution.energy, 1e-9);
  }
}

TEST(FeatureMatching, OtherProportionsAndDensity) {
  expect_identity(match(make_subject(slim, left_side), make_subject(stout, left_side)),
                  left_side.size());
}

TEST(FeatureMatching, MotionBeatsShape) {
  // Mirror-symmetric shape, features on both sides, and only one side moves: the same on both.
  const Subject a = make_subject(slim, with_mirror_image(left_side, 0.02));
  const Subject b = make_subject(stout, with_mirror_image(left_side, 0.02));
  const FeatureMatching m = match(a, b);
  EXPECT_GE(m.matches.size(), left_side.size());
  for (const FeatureMatch& k : m.matches) {
    EXPECT_EQ(k.source < left_side.size(), k.target < left_side.size()) << k.source;
  }
  // Motion alone suffices.
  for (const FeatureMatch& k : match(a, b, {.orientation = 0.0}).matches) {
    EXPECT_EQ(k.source < left_side.size(), k.target < left_side.size()) << k.source;
  }
}

TEST(FeatureMatching, TwistTellsLeftFromRightWhenBothMoveAlike) {
  const Subject a = make_subject(slim, with_mirror_image(left_side, 1.0));
  const Subject b = make_subject(stout, with_mirror_image(left_side, 1.0));
  expect_identity(match(a, b), 2 * left_side.size());
}

TEST(FeatureMatching, MissingFeaturesStayUnmatched) {
  const Subject a = make_subject(slim, left_side);
  Subject b = make_subject(stout, left_side);
  b.features.features.erase(b.features.features.begin() + 2);
  const FeatureMatching m = match(a, b);
  EXPECT_EQ(m.matches.size(), 4U);
  for (const FeatureMatch& k : m.matches) {
    EXPECT_EQ(k.target, k.source > 2 ? k.source - 1 : k.source);
  }
  EXPECT_EQ(m.unmatched_source, std::vector<uint32_t>{2});
}

TEST(FeatureMatching, BothPriorsKeepTheIdentity) {
  const Subject a = make_subject({.around = 14, .along = 40}, left_side);
  expect_identity(match(a, a, {.prior = GeodesicPrior::same_class}), left_side.size());
  // The printed rule forbids pairs that are non-monotonous on both, so it may match fewer.
  for (const FeatureMatch& k : match(a, a, {.prior = GeodesicPrior::printed}).matches) {
    EXPECT_EQ(k.source, k.target);
  }
}

TEST(FeatureMatching, FewOrNoFeaturesAreAnswered) {
  const Subject a = make_subject(slim, left_side);
  Subject none = a, one = a;
  none.features.features.clear();
  one.features.features.resize(1);
  EXPECT_FALSE(match(none, a).empty_reason.empty());
  EXPECT_FALSE(match(a, none).empty_reason.empty());
  EXPECT_TRUE(match(a, none).solution.certified);
  EXPECT_EQ(match(a, none).unmatched_source.size(), left_side.size());
  expect_identity(match(one, one), 1);
}

TEST(FeatureMatching, FeaturesAllAlikeAreAnswered) {
  Subject a = make_subject(slim, left_side);
  for (Feature& f : a.features.features) f = a.features.features.front();
  const FeatureMatching m = match(a, a);
  EXPECT_EQ(m.matches.size(), left_side.size());
}

TEST(FeatureMatching, DisconnectedMeshesGiveInfiniteDistancesNotTrouble) {
  const Subject part = make_subject(slim, left_side);
  // The same twice, side by side and not connected.
  std::vector<Triangle> faces = part.mesh.topology().faces();
  const auto count = static_cast<VertexIndex>(part.mesh.vertex_count());
  for (std::size_t f = 0, n = faces.size(); f < n; ++f) {
    faces.push_back({faces[f][0] + count, faces[f][1] + count, faces[f][2] + count});
  }
  Subject two{.mesh = AnimatedMesh(std::make_shared<const Topology>(2 * count, faces), 30, 30.0),
              .features = part.features};
  two.features.vertex_count = 2 * count;
  for (std::size_t f = 0; f < 30; ++f) {
    for (VertexIndex v = 0; v < count; ++v) {
      two.mesh.position(f, v) = part.mesh.position(f, v);
      two.mesh.position(f, v + count) = part.mesh.position(f, v) + Eigen::Vector3f(0, 0, 90);
    }
  }
  for (std::size_t k = 3; k < 5; ++k) two.features.features[k].vertex += count;
  expect_identity(match(two, two), left_side.size());
}

TEST(FeatureMatching, RefusesWhatDoesNotFit) {
  Subject a = make_subject(slim, left_side);
  Subject wrong = a;
  wrong.features.features[0].vertex = 1'000'000;
  EXPECT_THROW(feature_places(wrong.features, wrong.mesh), InputError);
  wrong = a;
  wrong.features.features[0].frame = 30;
  EXPECT_THROW(feature_places(wrong.features, wrong.mesh), InputError);
  EXPECT_THROW(feature_places(a.features, AnimatedMesh()), NoResultError);
  a.mesh.position(0, 5).x() = NAN;
  EXPECT_THROW(feature_places(a.features, a.mesh), InputError);
}

TEST(FeatureMatching, TooManyPairsAreRefusedWithTheRemedy) {
  const FeaturePlaces a = [] {
    const Subject s = make_subject(slim, left_side);
    return feature_places(s.features, s.mesh);
  }();
  try {
    match_features(a, a, {.max_pairs = 10});
    ADD_FAILURE() << "accepted";
  } catch (const NoResultError& e) {
    EXPECT_NE(e.details().remedy.find("--neighbours"), std::string::npos);
    EXPECT_NE(e.details().what.find("MB"), std::string::npos);
  }
}

TEST(FeatureMatching, ThousandsOfFeaturesAreRefusedBeforeTheirGeodesics) {
  EXPECT_THROW(refuse_too_many_features(3000, 2000, {}), NoResultError);
  EXPECT_THROW(refuse_too_many_features(200, 200, {.candidates = 0}), NoResultError);
  EXPECT_NO_THROW(refuse_too_many_features(3000, 2000, {.neighbours = 6}));
  EXPECT_NO_THROW(refuse_too_many_features(0, 0, {}));
}

TEST(FeatureMatching, WrittenAsJsonAndCsv) {
  const Subject a = make_subject(slim, left_side);
  const FeatureMatching m = match(a, a);
  const test::TemporaryFolder folder;
  write_matches(folder.path() / "m.json", m, a.features, a.features);
  const nlohmann::json json = nlohmann::json::parse(read_file(folder.path() / "m.json"));
  ASSERT_EQ(json["matches"].size(), left_side.size());
  EXPECT_EQ(json["matches"][1]["source_vertex"], a.features.features[1].vertex);
  EXPECT_TRUE(json["matches"][1].contains("margin"));
  write_matches(folder.path() / "m.csv", m, a.features, a.features);
  const std::string csv = read_file(folder.path() / "m.csv");
  EXPECT_EQ(std::ranges::count(csv, '\n'), 6);
  EXPECT_THROW(write_matches(folder.path() / "m.txt", m, a.features, a.features), UsageError);
}

}  // namespace
}  // namespace kinemesh::feature_matching_test
