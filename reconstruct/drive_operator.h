// How the displacements of markers spread over a scan: four interpolants, each a linear map from
// M markers to V vertices that is computed once and is exact at the markers.
//
//   surface      prior covariance (1 − ℓ² Δ)⁻³ of a random field that lives on the surface (Whittle
//                1963; Lindgren, Rue & Lindström 2011, with free edges), ℓ = `reach_mm`;
//                conditioned on the markers. Motion fades out where no markers are and never
//                crosses a gap between lips or lids.
//   geodesic     r-kernel with the exact geodesic distance instead of the straight one
//   biharmonic   least ∫ (Δu)² with the markers held (Botsch & Kobbelt 2004), free edges
//   euclidean    thin-plate spline in space: kernel r with an affine part (Carr et al. 2001)
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "config/run_context.h"
#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

enum class DriveMethod { surface, geodesic, biharmonic, euclidean };

struct DriveOperator {
  /// vertices × markers: rows to be multiplied with the markers' displacements. For a marker's
  /// own surface point the weighted rows of its corners give exactly that marker.
  Eigen::MatrixXf spread;
  /// markers × markers, positive definite, mean of the diagonal 1: the prior covariance of the
  /// surface method at the markers, whatever the method; what smoothing and gaps are judged by.
  Eigen::MatrixXd covariance;
  double reach_mm = 0.0;
  std::size_t solved_faces =
      0;  ///< of the mesh that was solved on: fewer than the scan's if coarse
  double seconds = 0.0;
};

/// Mean distance of each point to the nearest other one, mm; 0 for fewer than two.
double nearest_spacing(std::span<const Eigen::Vector3d> points);

/// `points` are distinct points of the scan, none of them invalid. `reach_mm` 0: 1.6 × the mean
/// distance to the nearest marker. A scan of more than `most_faces` (0: any number) is solved on a
/// coarser mesh (coarse_scan.h), no edge longer than a fifth of the reach, and the result carried
/// to the scan's vertices: still exact at the markers. Throws NoResultError when the scan cannot be
/// factorised.
DriveOperator make_drive_operator(const Topology& topology,
                                  std::span<const Eigen::Vector3d> positions,
                                  std::span<const SurfacePoint> points, DriveMethod method,
                                  double reach_mm = 0.0, std::size_t most_faces = 0,
                                  const RunContext& ctx = {});

}  // namespace kinemesh
