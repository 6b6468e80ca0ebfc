#include "mesh/surface_measures.h"

#include <Eigen/Geometry>

namespace kinemesh {
namespace {

Eigen::Vector3d area_vector(const Triangle& face, std::span<const Eigen::Vector3d> positions) {
  return 0.5 *
         (positions[face[1]] - positions[face[0]]).cross(positions[face[2]] - positions[face[0]]);
}

}  // namespace

std::vector<double> vertex_areas(const Topology& topology,
                                 std::span<const Eigen::Vector3d> positions) {
  std::vector<double> areas(topology.vertex_count(), 0.0);
  for (const Triangle& face : topology.faces()) {
    const double third = area_vector(face, positions).norm() / 3.0;
    for (const VertexIndex v : face) areas[v] += third;
  }
  return areas;
}

std::vector<Eigen::Vector3d> vertex_normals(const Topology& topology,
                                            std::span<const Eigen::Vector3d> positions) {
  std::vector<Eigen::Vector3d> normals(topology.vertex_count(), Eigen::Vector3d::Zero());
  for (const Triangle& t : topology.faces()) {
    const Eigen::Vector3d area = area_vector(t, positions);
    for (const VertexIndex v : t) normals[v] += area;
  }
  for (Eigen::Vector3d& n : normals) {
    const double length = n.norm();
    if (length > 0.0) n /= length;
  }
  return normals;
}

double mean_edge_length(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  double sum = 0.0;
  for (const Edge& edge : topology.edges()) {
    sum += (positions[edge.vertices[1]] - positions[edge.vertices[0]]).norm();
  }
  return topology.edge_count() > 0 ? sum / static_cast<double>(topology.edge_count()) : 0.0;
}

double bounding_diagonal(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  if (topology.face_count() == 0) return 0.0;
  Eigen::Vector3d low = positions[topology.faces()[0][0]], high = low;
  for (const Triangle& face : topology.faces()) {
    for (const VertexIndex v : face) {
      low = low.cwiseMin(positions[v]);
      high = high.cwiseMax(positions[v]);
    }
  }
  return (high - low).norm();
}

}  // namespace kinemesh
