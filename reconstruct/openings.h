// Openings of a face, found where the motion of the markers shows them: the mouth, the eyes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "reconstruct/edge_constraints.h"
#include "reconstruct/edit_mesh.h"

namespace kinemesh {

/// `gap` is a hole that the markers leave open in every frame, like the end of a sleeve.
enum class OpeningName { mouth, left_eye, right_eye, gap };

/// "mouth", "left eye", "right eye", "gap". Left is the subject's left.
std::string_view name_of(OpeningName name);

/// An opening of the surface beside its rim.
struct Opening {
  OpeningName name = OpeningName::gap;
  std::vector<VertexIndex> loop;  ///< its markers, in the direction of the boundary halfedges
  double score = 0.0;             ///< of the strip that was cut; 0 for a gap
  bool forced = false;            ///< asked for by name
};

/// An opening that was considered.
struct OpeningCandidate {
  OpeningName name = OpeningName::mouth;
  double score = 0.0;      ///< strength of its strip
  double threshold = 0.0;  ///< score from which it is opened
  bool opened = false;
  std::string reason;  ///< why it was not opened
};

/// Whether an opening is cut: where the motion shows it, always, or never.
enum class OpeningMode { automatic, open, closed };

/// Thresholds are in marker spacings h (mean distance to the five nearest).
struct OpeningOptions {
  OpeningMode mouth = OpeningMode::automatic;
  OpeningMode left_eye = OpeningMode::automatic;
  OpeningMode right_eye = OpeningMode::automatic;
  double mouth_seed = 0.7;  ///< least variation of length (1 % to 99 %) of the strongest edge
  double eye_score = 0.5;   ///< least sum of both eyes' mean scores, see docs/reconstruct.md

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct OpeningSearch {
  std::vector<Opening> openings;
  std::vector<OpeningCandidate> candidates;
  std::size_t jump_samples = 0;     ///< samples left out because the marker jumped
  double statistics_seconds = 0.0;  ///< spent on the statistics of the motion
};

/// Cuts the openings that the motion shows out of `mesh`, which covers them: the mouth where the
/// distance of markers across it varies most, the eyes where a mirror-symmetric pair of strips
/// shortens. `points` are the positions in the reference frame; mesh vertex v is marker
/// `original[v]` of the take. Loops are of mesh vertices.
/// Throws NoResultError for an opening that is asked for by name where no strip of edges allows
/// one.
OpeningSearch cut_openings(EditMesh& mesh, const Points& points, double spacing,
                           const MarkerSequence& take, const std::vector<VertexIndex>& original,
                           const OpeningOptions& options, const EdgeConstraints& constraints = {},
                           const RunContext& ctx = {});

}  // namespace kinemesh
