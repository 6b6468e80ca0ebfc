#include "mesh/pca/pca.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "config/error.h"
#include "tests/support/random_animation.h"

namespace kinemesh::pca_test {
namespace {

/// mean + Σ scores · modes with known orthonormal modes and uncorrelated scores.
AnimatedMesh low_rank(std::size_t frames, uint32_t columns, const std::vector<double>& amplitudes) {
  AnimatedMesh mesh = test::smooth_animation(columns, columns, frames, 60.0);
  const auto values = static_cast<Eigen::Index>(3 * mesh.vertex_count());
  const Eigen::VectorXf mean = Eigen::Map<const Eigen::VectorXf>(mesh.positions().data(), values);
  for (std::size_t f = 0; f < frames; ++f) {
    Eigen::Map<Eigen::VectorXf> frame(
        mesh.positions().data() + static_cast<Eigen::Index>(f) * values, values);
    frame = mean;
    for (std::size_t k = 0; k < amplitudes.size(); ++k) {
      const double phase =
          2 * M_PI * static_cast<double>((k + 1) * f) / static_cast<double>(frames);
      const auto score = static_cast<float>(amplitudes[k] * std::sqrt(2.0) * std::cos(phase));
      frame[static_cast<Eigen::Index>(k)] += score;  // mode k is the k-th unit vector
    }
  }
  return mesh;
}

void expect_known_modes(const PcaResult& pca, const std::vector<double>& amplitudes,
                        double tolerance) {
  ASSERT_GE(pca.mode_count(), amplitudes.size());
  double total = 0;
  for (std::size_t k = 0; k < amplitudes.size(); ++k) {
    total += amplitudes[k] * amplitudes[k];
    const auto column = static_cast<Eigen::Index>(k);
    EXPECT_NEAR(pca.modes(column, column), 1.0, tolerance);
    EXPECT_NEAR(std::sqrt(pca.variances[column]), amplitudes[k], tolerance * amplitudes[k] + 1e-3);
  }
  EXPECT_NEAR(pca.total_variance, total, 1e-3 * total);
  EXPECT_NEAR(pca.explained(amplitudes.size()), 1.0, 1e-6);
}

TEST(Pca, FindsKnownModesWithFewFramesAndWithFewCoordinates) {
  const std::vector<double> amplitudes{9, 5, 2, 0.5};
  expect_known_modes(pca_of(low_rank(40, 12, amplitudes)), amplitudes, 1e-4);  // 40 < 432
  expect_known_modes(pca_of(low_rank(500, 4, amplitudes)), amplitudes, 1e-4);  // 48 < 500
}

TEST(Pca, RandomisedFindsTheSame) {
  const std::vector<double> amplitudes{9, 5, 2, 0.5};
  const AnimatedMesh mesh = low_rank(900, 17, amplitudes);  // 900 × 867: both above 800
  expect_known_modes(pca_of(mesh, {.modes = 6}), amplitudes, 1e-3);
  RunContext two;
  two.set_threads(2);
  EXPECT_EQ(pca_of(mesh, {.modes = 6}).modes, pca_of(mesh, {.modes = 6}, two).modes);
}

TEST(Pca, ModesAreOrthonormalAndReconstruct) {
  const AnimatedMesh mesh = test::smooth_animation(10, 10, 60, 60.0);
  const PcaResult pca = pca_of(mesh);
  const Eigen::MatrixXf gram = pca.modes.transpose() * pca.modes;
  EXPECT_LT((gram - Eigen::MatrixXf::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(),
            1e-4);
  std::vector<double> scores(pca.mode_count());
  for (std::size_t k = 0; k < scores.size(); ++k)
    scores[k] = pca.scores(30, static_cast<Eigen::Index>(k));
  const Eigen::VectorXf frame = reconstruct(pca, scores);
  EXPECT_LT((frame - Eigen::Map<const Eigen::VectorXf>(mesh.frame(30).data(), frame.size()))
                .cwiseAbs()
                .maxCoeff(),
            1e-3);
}

TEST(Pca, StopsAtTheStatedError) {
  const AnimatedMesh mesh = test::smooth_animation(10, 10, 200, 60.0);
  const PcaResult all = pca_of(mesh);
  const PcaResult some = pca_of(mesh, {.rms_error_mm = 0.5});
  ASSERT_GT(some.mode_count(), 0U);
  ASSERT_LT(some.mode_count(), all.mode_count());
  EXPECT_LE(some.rms_error_mm(some.mode_count()), 0.5);
  EXPECT_GT(all.rms_error_mm(some.mode_count() - 1), 0.5);
  // The stated error is the one measured.
  double sum = 0;
  for (std::size_t f = 0; f < 200; ++f) {
    std::vector<double> scores(some.mode_count());
    for (std::size_t k = 0; k < scores.size(); ++k) {
      scores[k] = some.scores(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(k));
    }
    const Eigen::VectorXf frame = reconstruct(some, scores);
    sum += (frame - Eigen::Map<const Eigen::VectorXf>(mesh.frame(f).data(), frame.size()))
               .squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(sum / (200 * 100)), some.rms_error_mm(some.mode_count()), 1e-3);
}

TEST(Pca, StillAndEmptyMeshes) {
  const AnimatedMesh still = low_rank(20, 4, {});
  const PcaResult pca = pca_of(still);
  EXPECT_EQ(pca.total_variance, 0.0);
  EXPECT_EQ(pca.explained(0), 1.0);
  EXPECT_EQ(pca.rms_error_mm(0), 0.0);
  EXPECT_EQ(pca_of(test::smooth_animation(3, 3, 1, 60.0)).mode_count(), 0U);
  EXPECT_THROW(pca_of(AnimatedMesh(Topology::create(3, {{0, 1, 2}}), 0, 60.0)), InputError);
}

}  // namespace
}  // namespace kinemesh::pca_test
