// Another connectivity of the same surface, for tests that must not profit from equal topology.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh::test {

struct Remeshed {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Triangle> faces;
};

/// Isotropic remeshing (Botsch and Kobbelt 2004, CGAL's implementation) to about `vertex_count`
/// vertices, which stay on the surface; its boundary loops stay where they are.
Remeshed remesh(const std::vector<Eigen::Vector3d>& positions, const std::vector<Triangle>& faces,
                std::size_t vertex_count);

}  // namespace kinemesh::test
