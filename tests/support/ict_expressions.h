// Every expression of the linear face model, one a frame, as markers with noise see it, beside the
// truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/marker_sequence.h"
#include "mesh/mesh.h"
#include "reconstruct/drive_scan.h"
#include "tests/support/ict_performer.h"

namespace kinemesh::test {

struct IctExpressions {
  Mesh scan;                            ///< the subject at rest
  std::vector<AttachedMarker> markers;  ///< true places
  MarkerSequence measured;              ///< frame k: expression k at full strength, with noise
  std::vector<std::vector<Eigen::Vector3f>> truth;  ///< per frame, all vertices
  std::vector<bool> near_markers;  ///< per vertex: within 12 mm of a marker at rest
};

/// `identity` 0 is the neutral face. Markers are at least `least_mm` apart (9: about 160).
IctExpressions ict_expressions(uint64_t identity, double noise_mm = 0.2, double least_mm = 9.0,
                               double stand_off_mm = 0.0);

struct DriveError {
  double mean = 0.0, p95 = 0.0;
};
/// Over the chosen vertices (empty: all) of all frames, mm.
DriveError drive_error(const IctExpressions& ict, const AnimatedMesh& driven,
                       const std::vector<bool>& chosen = {});

/// The same recording without some of the markers, to be judged by place_error().
IctExpressions without_markers(const IctExpressions& ict, const std::vector<std::size_t>& left_out);
/// Over the places of these markers in all frames, mm.
DriveError place_error(const IctExpressions& ict, const std::vector<std::size_t>& markers,
                       const AnimatedMesh& driven);
/// So many marker indices, drawn from the seed, ascending.
std::vector<std::size_t> draw_markers(std::size_t count, std::size_t of, uint64_t seed);

}  // namespace kinemesh::test
