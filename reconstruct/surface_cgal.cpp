#include "reconstruct/surface_cgal.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace kinemesh {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

using VertexBase = CGAL::Advancing_front_surface_reconstruction_vertex_base_3<Kernel>;
using CellBase = CGAL::Advancing_front_surface_reconstruction_cell_base_3<Kernel>;
using Delaunay3 =
    CGAL::Delaunay_triangulation_3<Kernel,
                                   CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

/// Refuses facets with an edge above the bound; otherwise CGAL's own priority, the radius of the
/// smallest empty circumscribed sphere.
struct BoundedPriority {
  const std::vector<double>* bound = nullptr;

  template <class Front, class Cell>
  double operator()(const Front& front, Cell& cell, const int& index) const {
    for (int i = 0; i < 3; ++i) {
      const auto& a = cell->vertex((index + 1 + i) % 4);
      const auto& b = cell->vertex((index + 1 + (i + 1) % 3) % 4);
      if (front.triangulation_3().is_infinite(a) || front.triangulation_3().is_infinite(b)) {
        return std::numeric_limits<double>::infinity();
      }
      const double limit = std::max((*bound)[a->info()], (*bound)[b->info()]);
      if (CGAL::squared_distance(a->point(), b->point()) > limit * limit) {
        return std::numeric_limits<double>::infinity();
      }
    }
    return front.smallest_radius_delaunay_sphere(cell, index);
  }
};

}  // namespace

std::vector<Triangle> advancing_front(const Points& points,
                                      const std::vector<double>& edge_bound_of_vertex) {
  std::vector<std::pair<Kernel::Point_3, std::size_t>> indexed;
  indexed.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& p = points[i];
    indexed.emplace_back(Kernel::Point_3(p.x(), p.y(), p.z()), i);
  }
  Delaunay3 delaunay(indexed.begin(), indexed.end());
  if (delaunay.dimension() < 3) return {};
  using Reconstruction = CGAL::Advancing_front_surface_reconstruction<Delaunay3, BoundedPriority>;
  Reconstruction reconstruction(delaunay, BoundedPriority{&edge_bound_of_vertex});
  reconstruction.run();
  std::vector<Triangle> faces;
  const auto& surface = reconstruction.triangulation_data_structure_2();
  for (auto face = surface.faces_begin(); face != surface.faces_end(); ++face) {
    if (!face->is_on_surface()) continue;
    Triangle triangle{};
    for (int i = 0; i < 3; ++i) {
      triangle[i] = static_cast<VertexIndex>(face->vertex(i)->vertex_3()->info());
    }
    faces.push_back(triangle);
  }
  return faces;
}

std::vector<Triangle> planar_delaunay(const std::vector<Eigen::Vector2d>& points) {
  using Base = CGAL::Triangulation_vertex_base_with_info_2<VertexIndex, Kernel>;
  using Delaunay2 =
      CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Base>>;
  std::vector<std::pair<Kernel::Point_2, VertexIndex>> indexed;
  indexed.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    indexed.emplace_back(Kernel::Point_2(points[i].x(), points[i].y()),
                         static_cast<VertexIndex>(i));
  }
  Delaunay2 delaunay(indexed.begin(), indexed.end());
  std::vector<Triangle> faces;
  for (auto face = delaunay.finite_faces_begin(); face != delaunay.finite_faces_end(); ++face) {
    faces.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  }
  return faces;
}

}  // namespace kinemesh
