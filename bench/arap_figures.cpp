// Drives model faces as rigidly as possible (Sorkine & Alexa 2007; CGAL, spokes and rims), the
// markers held: for comparison. One JSON object a line, for tools/verify.d/10_driving.
// `arap_figures [IDENTITIES [FIRST]]`.
#define CGAL_EIGEN3_ENABLED
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_deformation.h>

#include <stdexcept>
#include <vector>

#include "bench/drive_accuracy.h"

namespace kinemesh {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

Point point_of(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

/// The scan with a vertex more in the face under each marker; those vertices come last.
SurfaceMesh with_marker_vertices(const test::IctExpressions& ict) {
  SurfaceMesh mesh;
  const auto vertex = [](std::size_t i) {
    return SurfaceMesh::Vertex_index(static_cast<SurfaceMesh::size_type>(i));
  };
  for (const auto& p : ict.scan.positions) mesh.add_vertex(point_of(p.cast<double>()));
  std::vector<std::size_t> centres(ict.scan.topology->face_count(), 0);
  for (const AttachedMarker& m : ict.markers) {
    if (centres[m.point.face] != 0) throw std::runtime_error("two markers in one face");
    centres[m.point.face] = mesh.number_of_vertices();
    mesh.add_vertex(point_of(position_of(m.point, *ict.scan.topology, ict.scan.positions)));
  }
  for (FaceIndex f = 0; f < centres.size(); ++f) {
    const Triangle& t = ict.scan.topology->faces()[f];
    if (centres[f] == 0) {
      mesh.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2]));
      continue;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      mesh.add_face(vertex(t.at(c)), vertex(t.at((c + 1) % 3)), vertex(centres[f]));
    }
  }
  return mesh;
}

AnimatedMesh as_rigid_as_possible(const test::IctExpressions& ict) {
  SurfaceMesh mesh = with_marker_vertices(ict);
  CGAL::Surface_mesh_deformation<SurfaceMesh> deformation(mesh);
  for (const auto v : mesh.vertices()) {
    if (!mesh.is_isolated(v)) deformation.insert_roi_vertex(v);
  }
  const auto first = static_cast<SurfaceMesh::size_type>(ict.scan.positions.size());
  const auto handle = [&](std::size_t m) {
    return SurfaceMesh::Vertex_index(first + static_cast<SurfaceMesh::size_type>(m));
  };
  for (std::size_t m = 0; m < ict.markers.size(); ++m) deformation.insert_control_vertex(handle(m));
  if (!deformation.preprocess()) throw std::runtime_error("the scan cannot be factorised");
  AnimatedMesh driven(ict.scan.topology, ict.measured.frame_count(), 0.0);
  for (std::size_t f = 0; f < driven.frame_count(); ++f) {
    deformation.reset();
    for (std::size_t m = 0; m < ict.markers.size(); ++m) {
      deformation.set_target_position(handle(m),
                                      point_of(ict.measured.position(f, m).cast<double>()));
    }
    deformation.deform(5, 1e-4);
    for (VertexIndex v = 0; v < driven.vertex_count(); ++v) {
      const Point& p = mesh.point(SurfaceMesh::Vertex_index(v));
      driven.position(f, v) = Eigen::Vector3d(p.x(), p.y(), p.z()).cast<float>();
    }
  }
  return driven;
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) {
  const auto [count, first] = kinemesh::identity_range(argc, argv, 1);
  for (uint64_t i = first; i < first + count; ++i) {
    kinemesh::print_accuracy(i, {"as rigid as possible", kinemesh::as_rigid_as_possible, count});
  }
}
