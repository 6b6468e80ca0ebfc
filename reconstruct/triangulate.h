// From the markers of a take to the topology of its surface.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/topology.h"
#include "reconstruct/openings.h"

namespace kinemesh {

struct TriangulateOptions {
  /// Frame number as in the file; -1 for the first one in which all markers are measured.
  int64_t frame = -1;
  double edge_bound = 2.2;            ///< longest edge of the advancing front, in marker spacings
  double rim_bound = 1.8;             ///< longest edge on the rim, in marker spacings
  double hole_bound = 4.0;            ///< longest edge of the fill of a hole, in marker spacings
  std::vector<std::string> edges;     ///< "A:B": these markers are joined
  std::vector<std::string> no_edges;  ///< "A:B": these markers are not joined
  OpeningOptions openings;

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// What the triangulation did, and how far it can be trusted.
struct TriangulateDiagnostics {
  double spacing = 0.0;      ///< h: mean distance of a marker to its five nearest, mm
  std::string method;        ///< "advancing front", "previous topology", or a fallback:
                             ///< "sphere chart", "plane chart"
  double bound = 0.0;        ///< edge bound that was used, in h
  std::size_t inserted = 0;  ///< markers that the front left out and that were inserted
  std::size_t holes_filled = 0;
  std::size_t rim_faces_trimmed = 0;
  std::size_t flips = 0;
  double longest_rim_edge = 0.0;  ///< over all boundary edges, in h
  double outwardness = 0.0;  ///< volume under the surface / area^1.5; near 0 the side is a guess
  std::size_t jump_samples = 0;  ///< left out of the search for openings because the marker jumped
  std::size_t frames_measured = 0;  ///< frames in which every marker is measured
  double seconds = 0.0;             ///< of the geometry, statistics of the motion aside
  std::vector<std::string> warnings;
};

struct TriangulateResult {
  /// Every marker of the take is a vertex, with the marker's index. Manifold, outwards, one
  /// component, Euler number 1 − openings (2 for a closed surface).
  std::shared_ptr<const Topology> topology;
  std::size_t frame = 0;      ///< reference frame, 0-based
  int64_t frame_number = 1;   ///< the same as numbered in the file
  bool all_measured = false;  ///< no sample of the reference frame is filled
  std::vector<Opening> openings;
  std::vector<OpeningCandidate> candidates;  ///< what was considered, accepted or not
  TriangulateDiagnostics diagnostics;
};

/// Triangulates the markers of a take in which every sample is valid (gaps filled before).
/// The result is the same whatever the position, orientation and marker order.
/// Throws InputError for an invalid or infinite sample, UsageError for a frame or marker that does
/// not exist or constraints that cannot be met, NoResultError for fewer than three markers or
/// markers on a line.
TriangulateResult triangulate(const MarkerSequence& take, const TriangulateOptions& options = {},
                              const RunContext& ctx = {});

}  // namespace kinemesh
