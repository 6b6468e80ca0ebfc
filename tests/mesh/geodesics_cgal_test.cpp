// Exact distances against CGAL's Surface_mesh_shortest_path, an implementation of its own. The
// only file here that knows CGAL.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>
#include <gtest/gtest.h>

#include <array>

#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesics.h"
#include "tests/support/data.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::geodesics_cgal_test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using ShortestPath =
    CGAL::Surface_mesh_shortest_path<CGAL::Surface_mesh_shortest_path_traits<Kernel, SurfaceMesh>>;

SurfaceMesh to_cgal(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  SurfaceMesh mesh;
  for (const Eigen::Vector3d& p : positions) mesh.add_vertex({p.x(), p.y(), p.z()});
  for (const auto& [a, b, c] : topology.faces()) {
    mesh.add_face(SurfaceMesh::Vertex_index(a), SurfaceMesh::Vertex_index(b),
                  SurfaceMesh::Vertex_index(c));
  }
  return mesh;
}

/// A source inside a face, and one at a vertex, by themselves and together.
void compare(const Topology& topology, std::span<const Eigen::Vector3d> positions,
             const std::string& name, bool points_in_faces = true) {
  SurfaceMesh mesh = to_cgal(topology, positions);
  ASSERT_EQ(mesh.number_of_faces(), topology.face_count()) << name;
  const GeodesicSolver solver(std::make_shared<const Topology>(topology), positions);
  const auto count = static_cast<VertexIndex>(topology.vertex_count());
  std::vector<std::vector<SurfacePoint>> trials{{vertex_point(topology, count / 2 + 7)}};
  if (points_in_faces) {
    const SurfacePoint inside{static_cast<FaceIndex>(topology.face_count() / 3), {0.2, 0.5, 0.3}};
    trials = {{inside}, {inside, vertex_point(topology, count / 2 + 7)}};
  }
  for (const std::vector<SurfacePoint>& sources : trials) {
    ShortestPath reference(mesh);
    for (const SurfacePoint& p : sources) {
      // Barycentric weights count from the target of the face's halfedge in CGAL's order.
      const SurfaceMesh::Face_index face(p.face);
      const auto h = mesh.halfedge(face);
      ShortestPath::Barycentric_coordinates weights{{0.0, 0.0, 0.0}};
      std::array<SurfaceMesh::Vertex_index, 3> corners{mesh.source(h), mesh.target(h),
                                                       mesh.target(mesh.next(h))};
      for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < 3; ++k) {
          if (topology.faces()[p.face][k] == static_cast<VertexIndex>(corners[c])) {
            weights[c] = p.weights[k];
          }
        }
      }
      reference.add_source_point(face, weights);
    }
    const GeodesicField field = solver.solve(sources);
    for (VertexIndex v = 0; v < count; ++v) {
      const double expected =
          reference.shortest_distance_to_source_points(SurfaceMesh::Vertex_index(v)).first;
      ASSERT_NEAR(field.distances[v], expected, 1e-6 * expected + 1e-12) << name << " vertex " << v;
    }
  }
}

TEST(GeodesicsCgal, GeneratedSurfacesAgree) {
  using namespace test;
  for (const Surface& s :
       {plane_grid(12, 0.3, 1), bumpy(plane_with_hole(12, 4, 7), 0.6, 5.0), cube(4, 10.0),
        bumpy(sphere(3, 10.0), 0.8, 5.0), bumpy(torus(30, 14, 10.0, 4.0, 0.1, 2), 0.5, 5.0),
        double_ring(), bumpy(double_ring(), 0.15, 3.0),
        with_slivers(bumpy(sphere(2, 10.0), 0.5, 6.0), 1e-4, 4),
        with_slivers(bumpy(torus(12, 8, 10.0, 4.0, 0.3, 3), 0.5, 6.0), 1e-5, 4),
        with_slivers(plane_grid(8, 0.2, 5), 1e-6, 5)}) {
    compare(*s.topology, s.positions, s.name);
  }
}

TEST(GeodesicsCgal, RealMeshesAgree) {
  // tools/verify.d/7_geodesics compares every mesh of the data folder; here one of each kind.
  for (const char* name : {"tosca_cat/cat3.off", "anim/horse_gallop.ply"}) {
    KINEMESH_NEED_DATA(name);
    const Mesh mesh = read_mesh(builtin_mesh_formats(), test::data_folder() / name);
    std::vector<Eigen::Vector3d> positions;
    for (const Eigen::Vector3f& p : mesh.positions) positions.emplace_back(p.cast<double>());
    compare(*mesh.topology, positions, name, false);
  }
}

}  // namespace
}  // namespace kinemesh::geodesics_cgal_test
