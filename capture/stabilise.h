// Head stabilisation: the rigid motion of the head is measured from markers fixed to it and taken
// out of the take, so that only the face's own motion is left. Run it before gap filling.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "capture/marker_selection.h"
#include "capture/marker_sequence.h"
#include "capture/rigid_fit.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

/// Where the head is in one frame.
struct HeadPose {
  /// From the head's own coordinates (those of the reference frame) to the recording's.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< mm
  std::size_t visible = 0;    ///< rigid markers of known place measured in this frame
  bool interpolated = false;  ///< too few were, or they stood on one line: between other frames
  double error_mm = 0.0;      ///< RMS distance of the measured rigid markers from the mean shape;
                              ///< of an interpolated pose: NaN

  Eigen::Vector3d to_head(const Eigen::Vector3d& point) const {
    return rotation.transpose() * (point - translation);
  }
};

/// The mean shape of the rigid markers and the weight of each.
struct RigidShape {
  std::vector<std::size_t> markers;        ///< indices into markers()
  std::vector<Eigen::Vector3d> positions;  ///< mm, head coordinates
  std::vector<double> weights;  ///< of the least squares; the mean is 1. 0: never seen together
                                ///< with enough others, its place is not known (NaN)
  std::vector<double> residuals_mm;  ///< RMS distance over the take, 3D

  Eigen::Vector3d centre() const;  ///< mean of the markers that have a place
};

/// The pose of one frame by weighted least squares over the visible markers of the shape:
/// `measured[k]` is the position of shape.markers[k], used where `visible[k]`. An interpolated pose
/// (identity here) comes back when fewer than three are visible or when they stand on one line.
/// The same function serves frames as they arrive and whole takes.
HeadPose fit_pose(const RigidShape& shape, std::span<const Eigen::Vector3d> measured,
                  const std::vector<bool>& visible);

struct StabiliseOptions {
  std::vector<std::string> rigid;  ///< wildcards; empty: the head rig by its usual names where half
                                   ///< of the frames show three of it, or else chosen from the
                                   ///< motion (rigid_markers.h)
  std::vector<std::string> rig_names = usual_head_rig_patterns();  ///< not a parameter of its own
  int reference_frame = 0;  ///< 1-based frame number as in the file; 0: the first with all rigid
                            ///< markers, or with the most

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct StabiliseResult {
  /// All samples in head coordinates, in which the head rests as in the reference frame.
  MarkerSequence take;
  std::vector<HeadPose> poses;  ///< one per frame
  RigidShape shape;
  std::size_t reference_frame = 0;  ///< 0-based
  double rms_error_mm = 0.0;        ///< over all frames that were measured
  std::size_t interpolated_frames = 0;
  bool chosen_from_motion = false;    ///< the rigid markers were found, not named
  std::vector<std::string> warnings;  ///< full sentences, also sent to ctx
};

/// Mean shape and poses by alternating least squares (generalised Procrustes analysis); a marker
/// that fits worse than the others counts less (weight 1 / (its variance + the median variance)).
/// The start is the frame that shows most of them; the others get their places from frames whose
/// poses are known, round by round, and are left out, with a warning, when there are none. Three or
/// more that are never seen with those (a second subject, after the first) are a body of their own,
/// with a warning: how the two lie to each other is not known.
/// Filled samples are not used as rigid. Poses between are interpolated (spherically, linearly at
/// the head's centre), at the ends held.
/// Throws UsageError for a name or frame that does not exist and NoResultError when no frame has
/// three rigid markers that are not on one line.
StabiliseResult stabilise_head(const MarkerSequence& take, const StabiliseOptions& options = {},
                               const RunContext& ctx = {});
/// The same with rigid markers given as indices; options.rigid is not used.
StabiliseResult stabilise_head(const MarkerSequence& take, std::span<const std::size_t> rigid,
                               const StabiliseOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
