// A recorded session moves a scan of the same subject: from raw markers to the animated scan.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/gap_fill.h"
#include "capture/marker_selection.h"
#include "capture/marker_sequence.h"
#include "capture/stabilise.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/mesh.h"
#include "reconstruct/drive_scan.h"
#include "reconstruct/register_scan.h"

namespace kinemesh {

struct AnimateOptions {
  MarkerSelectionOptions selection;
  StabiliseOptions head;
  GapFillOptions gaps;
  RegisterOptions attach;
  DriveOptions drive;
  /// Frame number of the session that shows the scan's expression; −1: the one that fits best.
  int64_t neutral = -1;
  /// Put the head's motion back: the result is in the session's coordinates, not in the scan's.
  bool head_motion = false;
  /// The frames of the result are held at once; what would take more is refused before it is made.
  double memory_gb = 4.0;
  /// Frames to drive, by number, as WriteOptions has them; what lies between is driven too. The
  /// markers are judged by all frames. Not a parameter.
  std::string frames{};

  void declare(ParameterSet& p);
  void validate() const;
};

struct AnimateResult {
  DriveResult drive;                     ///< drive.animation is the result
  Registration registration;             ///< indices refer to `labels`
  std::vector<std::string> labels;       ///< the chosen markers
  Mesh scan;                             ///< as driven: mm, outwards
  std::size_t openings = 0;              ///< of the scan: rim, eyes, mouth and holes
  double scale = 1.0;                    ///< that brought the scan to mm
  int64_t neutral_frame = 1;             ///< number in the file
  std::vector<Eigen::Vector3d> neutral;  ///< per label, in the scan's coordinates, mm
  std::vector<std::string> notes;        ///< corrections and doubts, full sentences
};

/// Reads the markers' places once the scan is in mm; empty: they are found.
using PlacesSource = std::function<std::vector<AttachedMarker>(const Mesh& scan, double scale)>;

/// Throws NoResultError and InputError as its stages do, each with its remedy.
AnimateResult animate_scan(const Mesh& scan, const MarkerSequence& session,
                           const PlacesSource& places = {}, const AnimateOptions& options = {},
                           const RunContext& ctx = {});

}  // namespace kinemesh
