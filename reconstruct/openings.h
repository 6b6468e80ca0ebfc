// Openings of a face, found where the motion of the markers shows them: the mouth, the eyes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"
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

struct OpeningOptions {
  OpeningMode mouth = OpeningMode::automatic;
  OpeningMode left_eye = OpeningMode::automatic;
  OpeningMode right_eye = OpeningMode::automatic;

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

}  // namespace kinemesh
