#include "mesh/laplacian.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "mesh/geodesics/intrinsic_delaunay.h"
#include "mesh/geodesics/intrinsic_lengths.h"

namespace kinemesh {

SurfaceOperators surface_operators(const Topology& topology,
                                   std::span<const Eigen::Vector3d> positions) {
  const auto count = static_cast<Eigen::Index>(topology.vertex_count());
  const IntrinsicTriangulation mesh = intrinsic_delaunay(topology, positions);
  SurfaceOperators result{Eigen::SparseMatrix<double>(count, count), Eigen::VectorXd::Zero(count)};
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(12 * mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& lengths = mesh.lengths[f];
    const double area2 = std::max(double_area(lengths[0], lengths[1], lengths[2]), 1e-300);
    for (std::size_t c = 0; c < 3; ++c) {
      const double opposite = lengths[(c + 1) % 3], one = lengths[c], other = lengths[(c + 2) % 3];
      const double cotangent = (one * one + other * other - opposite * opposite) / (2.0 * area2);
      const double weight = 0.5 * std::min(cotangent, 1e4);
      const auto i = static_cast<int>(mesh.faces[f][(c + 1) % 3]);
      const auto j = static_cast<int>(mesh.faces[f][(c + 2) % 3]);
      entries.insert(entries.end(),
                     {{i, i, weight}, {j, j, weight}, {i, j, -weight}, {j, i, -weight}});
      result.masses[static_cast<Eigen::Index>(mesh.faces[f][c])] += area2 / 6.0;
    }
  }
  result.stiffness.setFromTriplets(entries.begin(), entries.end());
  const double mean = count > 0 ? result.masses.mean() : 1.0;
  result.masses = result.masses.cwiseMax(1e-6 * (mean > 0.0 ? mean : 1.0));
  return result;
}

}  // namespace kinemesh
