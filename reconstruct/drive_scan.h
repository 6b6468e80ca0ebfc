// Markers drive a face scan: their displacements, freed of noise, spread over its surface in every
// frame.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/formats/frame_choice.h"
#include "mesh/mesh.h"
#include "reconstruct/drive_operator.h"

namespace kinemesh {

/// A marker's place on the scan.
struct AttachedMarker {
  std::string label;
  SurfacePoint point;         ///< foot of the marker on the skin
  double stand_off_mm = 0.0;  ///< its centre stands off the skin by this, along the normal
};

struct DriveOptions {
  DriveMethod method = DriveMethod::surface;
  double reach_mm = 0.0;  ///< 0: from the spacing of the markers
  /// A scan of more faces is solved on a coarser mesh and driven at full resolution.
  int64_t most_faces = 100000;
  bool smooth = true;
  double noise_mm = 0.0;  ///< 0: estimated
  double fade_s = 0.1;
  /// Frames of the take that are driven, with step 1; count 0: all. Noise and gaps are judged by
  /// the whole take. Not a parameter.
  FrameChoice frames{};

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct DriveResult {
  AnimatedMesh animation;
  double reach_mm = 0.0;
  std::size_t solved_faces = 0;    ///< of the mesh that was solved on; the scan's, or fewer
  double noise_mm = 0.0;           ///< of each coordinate, as taken; 0 without smoothing
  double largest_change_mm = 0.0;  ///< of a measured marker, by smoothing
  /// Per marker, root mean square distance in mm over its measured samples driven, between the
  /// marker and where the driven surface has it.
  std::vector<double> marker_error_mm;
  double operator_seconds = 0.0, frames_seconds = 0.0;
};

/// `take` has exactly the attached markers, in their order, every sample valid (gaps filled), in
/// the scan's coordinates and without head motion. Throws NoResultError for fewer than three
/// markers or two at one place, InputError for an invalid sample.
DriveResult drive_scan(const Mesh& scan, const std::vector<AttachedMarker>& markers,
                       const MarkerSequence& take, const DriveOptions& options = {},
                       const RunContext& ctx = {});

}  // namespace kinemesh
