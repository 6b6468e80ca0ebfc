// Where markers sit on a scan, found from their positions in one neutral frame: from any pose to
// the scan by many starts and robust point-to-plane ICP (Chen & Medioni 1992), then a smooth
// non-rigid pull for what a neutral face differs from its scan.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "capture/rigid_fit.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/mesh.h"
#include "reconstruct/drive_scan.h"

namespace kinemesh {

struct RegisterOptions {
  double marker_radius_mm = 0.0;  ///< centres stand off the skin by this
  double farthest_mm = 8.0;       ///< a marker farther from the scan than this is left out

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct Registration {
  RigidFit pose;                        ///< session → scan
  std::vector<std::size_t> kept;        ///< indices of markers that lie on the scan, ascending
  std::vector<AttachedMarker> markers;  ///< one per kept marker
  std::vector<double> distance_mm;  ///< per marker, after the rigid part: from the skin outwards,
                                    ///< the radius taken off
  double rms_mm = 0.0;              ///< of the kept ones
  std::vector<std::string> notes;   ///< full sentences
};

/// `neutral`: one position per marker, mm; `scan`: prepared, mm. Throws NoResultError, with the
/// remedy, when the markers do not fit: mirrored, another subject, too few on the scan.
Registration register_markers(const Mesh& scan, const std::vector<Eigen::Vector3d>& neutral,
                              const std::vector<std::string>& labels,
                              const RegisterOptions& options = {}, const RunContext& ctx = {});

/// The same with known places: only the pose is found. Throws NoResultError when the markers are
/// the mirror image of their places or far from them.
Registration register_at(const Mesh& scan, const std::vector<AttachedMarker>& places,
                         const std::vector<Eigen::Vector3d>& neutral,
                         const std::vector<std::string>& labels,
                         const RegisterOptions& options = {});

}  // namespace kinemesh
