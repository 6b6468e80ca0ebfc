// The main job: a recorded session becomes an animated mesh. Chooses markers, fills their gaps,
// removes the head's motion if asked to, triangulates one frame and carries the topology through
// all of them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/gap_fill.h"
#include "capture/gaps.h"
#include "capture/marker_selection.h"
#include "capture/marker_sequence.h"
#include "capture/stabilise.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/mesh.h"
#include "reconstruct/carry.h"
#include "reconstruct/triangulate.h"

namespace kinemesh {

struct ConvertOptions {
  MarkerSelectionOptions selection;
  bool stabilise = false;  ///< take the head's motion out
  StabiliseOptions head;
  GapFillOptions gaps;
  TriangulateOptions triangulate;
  CarryOptions carry;

  void declare(ParameterSet& p);
  void validate() const;
};

struct ConvertResult {
  AnimatedMesh animation;
  MarkerSelectionResult selection;   ///< indices refer to the session
  std::vector<Marker> markers;       ///< one per vertex
  std::vector<HeadPose> head_poses;  ///< one per frame; empty unless stabilised
  double head_error_mm = 0.0;        ///< RMS over the frames, of the rigid markers
  std::vector<std::string> rigid;    ///< labels of the markers taken as rigid
  std::vector<MarkerGaps> gaps;      ///< one per vertex, as recorded
  std::vector<Fill> fills;           ///< marker is the vertex
  TriangulateResult triangulation;
  std::vector<FrameQuality> quality;  ///< one per frame
  CarrySummary summary;
  std::vector<std::string> warnings;  ///< what is doubtful, in full sentences
};

/// Converts a session. With `previous`, its triangulation is used again by marker name.
/// Throws NoResultError when no marker is left or no mesh can be made of them, UsageError for
/// options that do not fit the session.
ConvertResult convert_session(const MarkerSequence& session, const ConvertOptions& options = {},
                              const std::optional<Mesh>& previous = {}, const RunContext& ctx = {});

}  // namespace kinemesh
