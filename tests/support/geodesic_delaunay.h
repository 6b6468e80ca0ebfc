// The reference triangulation of markers: the dual of their geodesic Voronoi diagram on the true
// surface. Distances run along the surface, never across an opening that is respected.
//
// Within each triangle of the fine surface the squared distances are interpolated linearly, which
// is exact on a plane (differences of squared distances are linear there); bisectors, Voronoi
// vertices and lengths follow by clipping.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tests/support/true_surface.h"

namespace kinemesh::test {

struct GeodesicDelaunayOptions {
  /// Slits that count as openings (by name); all others are closed for good first.
  std::vector<std::string> open;
  /// Distances are followed up to this many spacings h; triangles whose circumradius along the
  /// surface is larger do not exist.
  double radius = 2.2;
  /// Rim triangles with an outer edge longer than this many h are taken off (without pinching).
  double longest_rim_edge = 2.0;
  /// An edge is core when its Voronoi edge is at least this many h long and it does not lie on
  /// the outer rim of the trimmed triangulation.
  double core_length = 0.1;
};

struct GeodesicDelaunay {
  struct DualEdge {
    std::array<uint32_t, 2> sites;  ///< ascending
    double voronoi_length = 0;      ///< mm
    bool core = false;
    bool rim = false;  ///< on the outer boundary of `triangles`
  };
  struct Opening {
    std::string name;
    std::vector<uint32_t> ring;  ///< sites whose cells touch the slit, in order around it
  };
  /// Mean distance in mm of a site to its five nearest, straight.
  double spacing = 0;
  /// All pairs of sites whose cells meet, sorted by sites.
  std::vector<DualEdge> edges;
  /// Triangles of sites, outwards, trimmed at the outer rim.
  std::vector<Triangle> triangles;
  /// All of them, before trimming.
  std::vector<Triangle> all_triangles;
  std::vector<Opening> openings;
  std::vector<Eigen::Vector3d> sites;  ///< positions, mm
  TrueSurface surface;                 ///< with the other slits closed

  /// Null when the cells do not meet.
  const DualEdge* find(uint32_t a, uint32_t b) const;
};

/// `sites` are surface points of `surface`.
GeodesicDelaunay geodesic_delaunay(const TrueSurface& surface, std::span<const SurfacePoint> sites,
                                   const GeodesicDelaunayOptions& options = {});

/// Mean over all points of the mean distance to their five nearest.
double mean_spacing(std::span<const Eigen::Vector3d> points);
/// Per point, the mean distance to its five nearest.
std::vector<double> local_spacing(std::span<const Eigen::Vector3d> points);

}  // namespace kinemesh::test
