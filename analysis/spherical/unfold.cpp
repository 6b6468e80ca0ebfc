#include "analysis/spherical/unfold.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>

#include "analysis/spherical/spherical_map.h"

namespace kinemesh::spherical {

namespace {

/// The present mesh with its vertices numbered by their place in `alive`.
std::vector<Triangle> triangles_of(const RingMesh& mesh, std::span<const VertexIndex> alive,
                                   std::size_t vertex_count) {
  std::vector<VertexIndex> number(vertex_count, invalid_index);
  for (std::size_t k = 0; k < alive.size(); ++k) number[alive[k]] = static_cast<VertexIndex>(k);
  std::vector<Triangle> triangles;
  for (const VertexIndex v : alive) {
    const std::vector<VertexIndex>& ring = mesh.ring(v);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const VertexIndex b = ring[i], c = ring[(i + 1) % ring.size()];
      if (v < b && v < c) triangles.push_back({number[v], number[b], number[c]});
    }
  }
  return triangles;
}

}  // namespace

Eigen::Matrix3d nearest_rotation(std::span<const Eigen::Vector3d> from,
                                 std::span<const Eigen::Vector3d> to) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < from.size(); ++k) covariance += to[k] * from[k].transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, 1);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

void unfold(const RingMesh& mesh, std::span<const Eigen::Vector3d> rest,
            std::vector<Eigen::Vector3d>& points, const RunContext& ctx) {
  std::vector<VertexIndex> alive = mesh.alive();
  std::ranges::sort(alive);
  std::vector<Eigen::Vector3d> positions, before;
  for (const VertexIndex v : alive) {
    positions.push_back(rest[v]);
    before.push_back(points[v]);
  }
  const Topology topology(alive.size(), triangles_of(mesh, alive, points.size()));
  if (check_sphere(topology, before).valid()) return;
  const SphericalMap map = map_to_sphere(topology, positions, {}, ctx);
  const Eigen::Matrix3d turn = nearest_rotation(map.points, before);
  for (std::size_t k = 0; k < alive.size(); ++k)
    points[alive[k]] = (turn * map.points[k]).normalized();
}

}  // namespace kinemesh::spherical
