// Geodesic distances from one point over a surface, by unfolding: a vertex takes its distance
// from the planar image of the source over each adjacent edge (Novotni and Klein 2002), in
// label-correcting order, so that obtuse triangles do no harm; paths bend at boundary vertices.
// Exact on a plane, with or without slits that bend a path once; elsewhere second order in the
// edge length.
#pragma once

#include <limits>
#include <utility>
#include <vector>

#include "tests/support/true_surface.h"

namespace kinemesh::test {

class SurfaceDistance {
 public:
  /// Keeps references to the surface's topology and positions.
  explicit SurfaceDistance(const TrueSurface& surface);

  struct VertexDistance {
    VertexIndex vertex;
    double distance;  ///< mm along the surface
  };
  /// All vertices within `radius` of the source, in no order.
  std::vector<VertexDistance> from(const SurfacePoint& source, double radius);
  static constexpr double unreached = std::numeric_limits<double>::infinity();

 private:
  struct Label {
    double distance = unreached;
    double bend = 0;                   // distance at which the path last bent
    VertexIndex root = invalid_index;  // the boundary vertex where it bent
  };
  static double unfold(double da, double db, double length, double cx, double cy);
  Label across(VertexIndex a, VertexIndex b, VertexIndex c) const;
  Label along(VertexIndex a, VertexIndex c) const;
  void offer(VertexIndex v, const Label& label, double radius);
  void relax_around(VertexIndex v, double radius);

  const TrueSurface& surface_;
  std::vector<Label> labels_;
  std::vector<VertexIndex> touched_;
  std::vector<std::pair<double, VertexIndex>> queue_;
};

}  // namespace kinemesh::test
