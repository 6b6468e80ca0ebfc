#include "mesh/movement.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace kinemesh {
namespace {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The rotation that turns centred `from` best onto centred `onto`.
Eigen::Matrix3d best_rotation(const Points& from, const Points& onto) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(from.transpose() * onto,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn(2, 2) = (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixV() * turn * svd.matrixU().transpose();
}

Points centred(Points points) {
  points.rowwise() -= points.colwise().mean().eval();
  return points;
}

}  // namespace

std::vector<double> movement_of(const AnimatedMesh& mesh, const RunContext& ctx) {
  const std::size_t frames = mesh.frame_count(), vertices = mesh.vertex_count();
  std::vector<double> squares(vertices, 0.0);
  if (frames < 2 || vertices == 0) return squares;
  // Aligned to the first frame, then to the mean of the aligned frames.
  Points reference = centred(mesh.frame(0).cast<double>());
  for (int pass = 0; pass < 2; ++pass) {
    ctx.check_cancelled();
    Points mean = Points::Zero(static_cast<Eigen::Index>(vertices), 3);
    std::fill(squares.begin(), squares.end(), 0.0);
    for (std::size_t f = 0; f < frames; ++f) {
      const Points points = centred(mesh.frame(f).cast<double>());
      const Points aligned = points * best_rotation(points, reference).transpose();
      mean += aligned;
      for (std::size_t v = 0; v < vertices; ++v) {
        const auto row = static_cast<Eigen::Index>(v);
        squares[v] += (aligned.row(row) - reference.row(row)).squaredNorm();
      }
    }
    if (pass == 0) reference = mean / static_cast<double>(frames);
  }
  for (double& s : squares) s = std::sqrt(s / static_cast<double>(frames));
  return squares;
}

}  // namespace kinemesh
