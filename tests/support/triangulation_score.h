// How good a triangulation of markers is, against the geodesic Delaunay triangulation on the true
// surface.
#pragma once

#include <string>
#include <vector>

#include "tests/support/geodesic_delaunay.h"

namespace kinemesh::test {

struct OpeningScore {
  std::string name;
  bool found = false;         ///< the mesh has a hole around the middle of the slit
  std::size_t ring_size = 0;  ///< vertices of the mesh's hole; 0 when not found
  std::size_t true_ring_size = 0;
  /// Triangles of the mesh that lie in the true opening, and of the reference that lie in the
  /// mesh's one (by more than half of their area).
  std::size_t differing_triangles = 0;
  std::size_t edges_across = 0;  ///< edges of the mesh that cross the slit
};

struct TriangulationScore {
  double precision = 0;         ///< share of the mesh's edges that belong to the reference
  double recall = 0;            ///< share of the reference's core edges that the mesh has
  double rms_mm = 0;            ///< between mesh and true surface, both ways, in the marked region
  double reference_rms_mm = 0;  ///< the same for the reference triangulation
  double rms_ratio = 0;         ///< rms_mm / reference_rms_mm
  double longest_rim_edge = 0;  ///< over the mean distance to the five nearest, of all markers
  double longest_rim_edge_local = 0;   ///< the same, over the mean of the edge's two ends
  std::vector<OpeningScore> openings;  ///< those that the motion opens
  std::size_t false_openings = 0;      ///< holes of the mesh where nothing opens
  std::size_t edges_across = 0;
  bool openings_right = false;  ///< all found, none false
  bool manifold = false;
  bool all_markers = false;  ///< no marker without a triangle
  bool outwards = false;     ///< oriented like the true surface
  std::size_t components = 0;
  int64_t euler = 0;
  /// One line for test output.
  std::string summary() const;
};

/// Vertex i of `mesh` is site i of the reference.
TriangulationScore score_triangulation(const Topology& mesh, const GeodesicDelaunay& reference);

/// Root mean square distance in mm between the triangles over the reference's sites and the true
/// surface, in both directions; of the surface only what lies under the reference's inner
/// triangles counts.
double rms_to_surface(const std::vector<Triangle>& triangles, const GeodesicDelaunay& reference);

}  // namespace kinemesh::test
