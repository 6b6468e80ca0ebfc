// The whole cleaning of a session, in the order in which its stages need each other: twins united,
// labels given, labels and spikes repaired, gaps filled, trajectories smoothed, the head's motion
// taken out.
#pragma once

#include <string>
#include <vector>

#include "capture/edit_list.h"
#include "capture/filter.h"
#include "capture/gap_fill.h"
#include "capture/repair.h"
#include "capture/stabilise.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

struct CleanOptions {
  bool label = true;          ///< give labels to points without identity
  std::string template_file;  ///< labelled take of the subject; empty: the take's own labels
  bool repair = true;
  RepairOptions repairs;
  bool fill = true;
  GapFillOptions gaps;
  FilterOptions filter{.method = FilterMethod::none};
  bool stabilise = false;
  StabiliseOptions head;

  void declare(ParameterSet& p);
  void validate() const;
};

/// Wall time of one stage.
struct StageTime {
  std::string stage;
  double seconds = 0.0;
};

struct CleanResult {
  MarkerSequence take;
  EditList edits;  ///< what was done, step by step: applied to the original they give
                   ///< the same take, and each can be left out
  std::vector<std::string> done;  ///< one sentence a step
  std::vector<StageTime> times;
};

/// A label of the body is used by two columns.
bool has_twins(const MarkerSequence& take);

/// Throws NoResultError when nothing has a label and no template is given, or when the take has no
/// frame or no point.
CleanResult clean_take(const MarkerSequence& take, const CleanOptions& options = {},
                       const RunContext& ctx = {});

}  // namespace kinemesh
