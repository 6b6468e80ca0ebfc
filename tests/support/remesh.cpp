#include "tests/support/remesh.h"

#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <Eigen/Geometry>
#include <cmath>

namespace kinemesh::test {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

}  // namespace

Remeshed remesh(const std::vector<Eigen::Vector3d>& positions, const std::vector<Triangle>& faces,
                std::size_t vertex_count) {
  SurfaceMesh mesh;
  for (const Eigen::Vector3d& p : positions) mesh.add_vertex({p.x(), p.y(), p.z()});
  double area = 0;
  for (const Triangle& t : faces) {
    mesh.add_face(SurfaceMesh::Vertex_index(t[0]), SurfaceMesh::Vertex_index(t[1]),
                  SurfaceMesh::Vertex_index(t[2]));
    area += (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).norm() / 2;
  }
  // Equilateral triangles of edge e, two for each vertex: A = n √3 / 2 e². Lengths end up about a
  // tenth below the target.
  const double edge =
      1.1 * std::sqrt(2 * area / (std::sqrt(3.0) * static_cast<double>(vertex_count)));
  namespace pmp = CGAL::Polygon_mesh_processing;
  pmp::isotropic_remeshing(mesh.faces(), edge, mesh, pmp::parameters::number_of_iterations(4));
  mesh.collect_garbage();
  Remeshed result;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    result.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : mesh.faces()) {
    Triangle t{};
    std::size_t corner = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      t.at(corner++) = static_cast<VertexIndex>(v);
    }
    result.faces.push_back(t);
  }
  return result;
}

}  // namespace kinemesh::test
