#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "config/error.h"
#include "tests/support/closest_point.h"
#include "tests/support/data.h"
#include "tests/support/ict_performer.h"
#include "tests/support/synthetic_body.h"

namespace kinemesh::test::synthetic_ict_test {
namespace {

class IctPerformer : public testing::Test {
 protected:
  void SetUp() override { KINEMESH_NEED_DATA("face_ict/neutral.ply"); }
};

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST_F(IctPerformer, TheModelIsAFaceInMillimetres) {
  const IctModel& model = ict_model();
  EXPECT_EQ(model.neutral.size(), 9409U);
  EXPECT_EQ(model.identities.size(), 50U);
  EXPECT_EQ(model.expressions.size(), 57U);
  EXPECT_EQ(model.landmarks.size(), 68U);
  const double eyes =
      (model.neutral[model.landmarks[36]] - model.neutral[model.landmarks[45]]).norm();
  EXPECT_GT(eyes, 80);  // outer corners
  EXPECT_LT(eyes, 110);
  const auto& open = model.expressions[model.expression("jawOpen")];
  EXPECT_LT(open[model.landmarks[8]].y(), -15);      // the chin goes down
  EXPECT_LT(open[model.landmarks[27]].norm(), 0.5);  // the root of the nose does not
  EXPECT_THROW(model.expression("jawOpne"), UsageError);
}

TEST(IctModelFiles, MissingOrShortOnesAreNamed) {
  EXPECT_THROW(load_ict("/nonexistent"), InputError);
  KINEMESH_NEED_DATA("face_ict/neutral.ply");
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "kinemesh_short_ict";
  fs::create_directories(folder);
  for (const char* name : {"neutral.ply", "meta.json"}) {
    fs::copy_file(data_folder() / "face_ict" / name, folder / name,
                  fs::copy_options::overwrite_existing);
  }
  std::ofstream(folder / "identity_deltas.f32") << "short";
  try {
    load_ict(folder);
    ADD_FAILURE() << "a short file was read";
  } catch (const InputError& error) {
    EXPECT_NE(error.details().file.find("identity_deltas.f32"), std::string::npos);
  }
  fs::remove_all(folder);
}

TEST_F(IctPerformer, OnItsOwnConnectivityVertexIsVertex) {
  const IctModel& model = ict_model();
  const IctActor actor(model, {.seed = 3}, make_ict_motion(model, 1));
  const Performance p = perform(actor);
  EXPECT_EQ(p.mesh.frame_count(), 120U);
  EXPECT_EQ(p.mesh.shared_topology(), model.topology);
  const auto shape = actor.at(1.0);
  for (VertexIndex v = 0; v < model.neutral.size(); v += 11) {
    EXPECT_LT((p.mesh.position(60, v).cast<double>() - shape[v]).norm(), 1e-3);
  }
  // People differ, and so do motions.
  const IctActor other(model, {.seed = 4}, make_ict_motion(model, 1));
  EXPECT_GT((other.rest()[model.landmarks[30]] - actor.rest()[model.landmarks[30]]).norm(), 0.5);
  const auto strengths = [&](uint64_t seed) {
    return IctActor(model, {.seed = 3}, make_ict_motion(model, seed)).strengths(1.0);
  };
  EXPECT_NE(strengths(1), strengths(2));
}

TEST_F(IctPerformer, MotionsMoveSeveralRegionsOneAfterTheOther) {
  const IctModel& model = ict_model();
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const IctMotion motion = make_ict_motion(model, seed);
    EXPECT_GE(motion.pulses.size(), 5U);
    const IctActor actor(model, {.seed = 0}, motion);
    EXPECT_LT(rms(actor.strengths(0)), 0.2);
    double largest = 0;
    for (double t = 0; t < 2; t += 0.05) {
      const auto shape = actor.at(t);
      for (std::size_t v = 0; v < shape.size(); v += 5) {
        largest = std::max(largest, (shape[v] - actor.rest()[v]).norm());
      }
    }
    EXPECT_GT(largest, 4) << seed;
  }
}

TEST_F(IctPerformer, VariationTurnsScalesAndDelays) {
  const IctModel& model = ict_model();
  const IctMotion motion = make_ict_motion(model, 2);
  const auto displacement = [&](const IctActor& a, double t, std::size_t v) -> Eigen::Vector3d {
    return a.at(t)[v] - a.rest()[v];
  };
  const IctActor one(model, {.seed = 5}, motion), two(model, {.seed = 6}, motion);
  const std::size_t lip = model.landmarks[57];
  EXPECT_LT((displacement(one, 0.9, lip) - displacement(two, 0.9, lip)).norm(), 1e-9);

  const IctActor turned(model, {.seed = 5}, motion, {.turn_degrees = 20});
  double largest = 0;
  const auto plain_shape = one.at(0.9), turned_shape = turned.at(0.9);
  for (std::size_t v = 0; v < plain_shape.size(); ++v) {
    const Eigen::Vector3d a = plain_shape[v] - one.rest()[v],
                          b = turned_shape[v] - turned.rest()[v];
    EXPECT_NEAR(a.norm(), b.norm(), 1e-6);
    if (a.norm() > 1)
      largest = std::max(largest, std::acos(std::min(1.0, a.dot(b) / a.squaredNorm())));
  }
  EXPECT_GT(largest * 180 / std::numbers::pi, 5);
  EXPECT_LT(largest * 180 / std::numbers::pi, 20.001);

  const IctActor late(model, {.seed = 5}, motion, {.delay_s = 0.3});
  EXPECT_GT(late.delay_s(), 0);
  EXPECT_EQ(late.strengths(1.0 + late.delay_s()), one.strengths(1.0));

  const IctActor scaled(model, {.seed = 5}, motion, {.scale = 0.3});
  const auto a = one.strengths(0.9), b = scaled.strengths(0.9);
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(b[k], a[k], 0.3 * a[k] + 1e-12);
  EXPECT_NE(a, b);
}

TEST_F(IctPerformer, AnotherConnectivityCarriesTheSameSurface) {
  const IctModel& model = ict_model();
  const IctActor actor(model, {.seed = 7}, make_ict_motion(model, 3));
  const Performance own = perform(actor), other = perform(actor, {.remesh_vertices = 5000});
  const Topology& t = other.mesh.topology();
  EXPECT_TRUE(t.is_manifold());
  EXPECT_EQ(t.boundary_loops().size(), model.topology->boundary_loops().size());
  EXPECT_NEAR(static_cast<double>(t.vertex_count()), 5000, 300);
  for (const std::size_t f : {0U, 45U, 75U}) {
    std::vector<Eigen::Vector3d> fine, coarse;
    for (VertexIndex v = 0; v < own.mesh.vertex_count(); ++v) {
      fine.push_back(own.mesh.position(f, v).cast<double>());
    }
    for (VertexIndex v = 0; v < t.vertex_count(); ++v) {
      coarse.push_back(other.mesh.position(f, v).cast<double>());
    }
    const ClosestPoint surface(fine, model.topology->faces(), 5);
    std::vector<double> centres, vertices;
    for (const Triangle& face : t.faces()) {
      centres.push_back(
          surface.closest((coarse[face[0]] + coarse[face[1]] + coarse[face[2]]) / 3).distance);
    }
    for (const Eigen::Vector3d& p : coarse) vertices.push_back(surface.closest(p).distance);
    EXPECT_LT(rms(vertices), 1e-3);  // float
    EXPECT_LT(rms(centres), 0.3);
  }
}

TEST_F(IctPerformer, TheTrueMapLeadsToTheSamePlace) {
  const IctModel& model = ict_model();
  const IctMotion motion = make_ict_motion(model, 1);
  const Performance a = perform(model, {.seed = 8}, motion, {.remesh_vertices = 6000});
  const Performance b = perform(model, {.seed = 9}, motion, {.remesh_vertices = 5000});
  const Performance own = perform(model, {.seed = 9}, motion);
  const SurfaceMap to_own = true_map(model, a, own), to_other = true_map(model, a, b);
  ASSERT_EQ(to_own.points.size(), a.mesh.vertex_count());
  ASSERT_EQ(to_other.points.size(), a.mesh.vertex_count());
  // Both lead to the same subject's face: to the same place but for the other mesh's flat
  // triangles.
  std::vector<double> apart;
  const auto at = [](const Performance& p, const SurfacePoint& point, std::size_t frame) {
    std::vector<Eigen::Vector3d> corners;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const VertexIndex v = p.mesh.topology().faces()[point.face][k];
      sum += point.weights[k] * p.mesh.position(frame, v).cast<double>();
    }
    return sum;
  };
  for (const std::size_t frame : {0U, 60U}) {
    for (std::size_t v = 0; v < a.mesh.vertex_count(); ++v) {
      apart.push_back((at(own, to_own.points[v], frame) - at(b, to_other.points[v], frame)).norm());
    }
  }
  EXPECT_LT(rms(apart), 0.6);
  std::sort(apart.begin(), apart.end());
  EXPECT_LT(apart[apart.size() * 99 / 100], 1.5);
}

TEST_F(IctPerformer, NoiseAndHeadMotionAreAsAskedFor) {
  const IctModel& model = ict_model();
  const IctActor actor(model, {.seed = 2}, make_ict_motion(model, 1, 0.5));
  const Performance clean = perform(actor);
  const Performance rough = perform(actor, {.noise_mm = 0.3, .head_degrees = 8, .head_mm = 20});
  std::vector<double> errors;
  for (std::size_t f = 0; f < clean.mesh.frame_count(); f += 5) {
    const Eigen::Isometry3d back = rough.head_pose[f].inverse();
    for (VertexIndex v = 0; v < clean.mesh.vertex_count(); ++v) {
      const Eigen::Vector3d d = back * rough.mesh.position(f, v).cast<double>() -
                                clean.mesh.position(f, v).cast<double>();
      for (int k = 0; k < 3; ++k) errors.push_back(d[k]);
    }
  }
  EXPECT_NEAR(rms(errors), 0.3, 0.005);
}

TEST_F(IctPerformer, MarkersSitOnTheFaceAndAreRecorded) {
  const IctModel& model = ict_model();
  const auto points = place_ict_markers(model, 8, 1);
  EXPECT_NEAR(static_cast<double>(points.size()), 165, 35);
  const auto places = positions_of({model.topology, model.neutral, {}, {}}, points);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_LT(std::max({points[i].weights[0], points[i].weights[1], points[i].weights[2]}),
              1 - 1e-6);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((places[i] - places[j]).norm(), 8);
  }
  const IctActor actor(model, {.seed = 4}, make_ict_motion(model, 2));
  const IctTake take = record_ict(
      actor, points,
      {.rate_hz = 60, .noise_mm = 0.2, .short_gaps = 20, .head_degrees = 5, .head_mm = 10});
  EXPECT_EQ(take.measured.frame_count(), 120U);
  EXPECT_GE(take.gaps.size(), 10U);
  const auto shape = actor.at(1.0);
  std::vector<double> errors;
  for (std::size_t m = 0; m < points.size(); ++m) {
    const Eigen::Vector3d p = take.head_pose[60] * position_of(points[m], *model.topology, shape);
    EXPECT_LT((p - take.truth.position(60, m).cast<double>()).norm(), 1e-3);
    if (take.measured.valid(60, m)) {
      errors.push_back((p - take.measured.position(60, m).cast<double>()).norm() / std::sqrt(3.0));
    }
  }
  EXPECT_NEAR(rms(errors), 0.2, 0.03);
}

}  // namespace
}  // namespace kinemesh::test::synthetic_ict_test
