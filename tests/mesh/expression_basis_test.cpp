#include "mesh/pca/expression_basis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "config/output_file.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::expression_basis_test {
namespace {

/// Two known shapes that rise and fall; `phase` tells two performances apart.
AnimatedMesh performance(double phase, std::size_t frames = 40) {
  const auto topology = Topology::create(4, {{0, 1, 2}, {0, 2, 3}});
  AnimatedMesh mesh(topology, frames, 50.0);
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = 0.2 * static_cast<double>(f) + phase;
    for (VertexIndex v = 0; v < 4; ++v) {
      mesh.position(f, v) =
          Eigen::Vector3f(static_cast<float>(v), static_cast<float>((v % 2) * std::sin(t)),
                          static_cast<float>(0.3 * (v / 2) * std::cos(2.0 * t)));
    }
  }
  return mesh;
}

TEST(ExpressionBasis, TwoShapesAreTwoModesAndGiveBothPerformancesBack) {
  const std::vector<AnimatedMesh> both{performance(0.0), performance(1.1, 25)};
  ExpressionBasis basis = make_expression_basis(both, {.rms_error_mm = 1e-4});
  EXPECT_EQ(basis.pca.mode_count(), 2U);
  EXPECT_EQ(basis.frame_counts, (std::vector<std::size_t>{40, 25}));
  EXPECT_NEAR(basis.pca.explained(2), 1.0, 1e-6);
  const ExpressionScores scores = express(basis, both[1]);
  EXPECT_LT(scores.rms_error_mm.maxCoeff(), 1e-4);
  EXPECT_GT(scores.explained, 0.9999);
  EXPECT_LT((scores.scores - basis.pca.scores.bottomRows(25)).cwiseAbs().maxCoeff(), 1e-4);
  const AnimatedMesh again = animation_from(basis, scores.scores, 50.0);
  for (std::size_t i = 0; i < again.positions().size(); ++i) {
    ASSERT_NEAR(again.positions()[i], both[1].positions()[i], 1e-4F);
  }
}

TEST(ExpressionBasis, FilesGiveTheSameScores) {
  const test::TemporaryFolder folder;
  ExpressionBasis basis = make_expression_basis({performance(0.0)}, {.rms_error_mm = 1e-4});
  basis.sources = {"one.ply"};
  write_expression_basis(folder.path() / "basis.npz", basis);
  const ExpressionBasis read = read_expression_basis(folder.path() / "basis.npz");
  EXPECT_EQ(*read.topology, *basis.topology);
  EXPECT_EQ(read.pca.mean, basis.pca.mean);
  EXPECT_EQ(read.pca.modes, basis.pca.modes);
  EXPECT_EQ(express(read, performance(0.4)).scores, express(basis, performance(0.4)).scores);
  const std::string csv = scores_csv(express(read, performance(0.4, 2)), 50.0, 7);
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "frame,time_s,rms_error_mm,mode_1,mode_2");
  EXPECT_NE(csv.find("\n8,0.02,"), std::string::npos);
}

TEST(ExpressionBasis, OtherMeshesAndBrokenFilesAreRefused) {
  EXPECT_THROW(make_expression_basis({}), InputError);
  const ExpressionBasis basis = make_expression_basis({performance(0.0)}, {.modes = 1});
  AnimatedMesh other(Topology::create(4, {{0, 1, 2}}), 2, 50.0);
  std::ranges::fill(other.positions(), 0.0F);
  EXPECT_THROW(express(basis, other), InputError);
  const test::TemporaryFolder folder;
  write_file(folder.path() / "basis.npz", "no archive");
  EXPECT_THROW(read_expression_basis(folder.path() / "basis.npz"), InputError);
}

}  // namespace
}  // namespace kinemesh::expression_basis_test
