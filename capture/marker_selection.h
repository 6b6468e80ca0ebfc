// Which markers of a session become vertices, and why: by subject, name pattern and kind.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

/// Names (any case) that the usual rigid head markers go by: NaturalPoint's root-*, head bands and
/// helmets, and the four head markers and the crown marker of Vicon's Plug-in Gait.
std::vector<std::string> usual_head_rig_patterns();

struct MarkerSelectionOptions {
  std::vector<std::string> subjects;            ///< wildcards; empty: all
  std::vector<std::string> include;             ///< wildcards; empty: all
  std::vector<std::string> exclude;             ///< wildcards
  std::vector<std::string> kinds = {"marker"};  ///< words of name_of(MarkerKind)
  bool head_rig = false;                        ///< choose the head rig's markers too
  std::vector<std::string> head_rig_patterns = usual_head_rig_patterns();

  void declare(ParameterSet& p);
  /// Throws UsageError, also for an unknown kind.
  void validate() const;
};

/// Why a marker was chosen or not.
enum class SelectionReason {
  chosen,         ///< it passed every rule
  other_subject,  ///< its subject is not among those asked for
  not_included,   ///< no pattern to include matches
  excluded,       ///< a pattern to exclude matches
  other_kind,     ///< unlabelled, or no marker of the body
  head_rig,       ///< fixed to the head rig, not to the skin
  never_valid,    ///< invalid in every frame
};

struct MarkerDecision {
  bool chosen = false;
  SelectionReason reason = SelectionReason::chosen;
  bool head_rig = false;  ///< its name is one of a head rig
  std::string text;       ///< the reason as a user reads it: "unlabelled; ask with --kind …"
};

struct MarkerSelectionResult {
  std::vector<std::size_t> chosen;        ///< indices into markers(), ascending
  std::vector<std::size_t> head_rig;      ///< rigid head markers of the chosen subjects that are
                                          ///< valid at least once, chosen or not, ascending
  std::vector<MarkerDecision> decisions;  ///< one per marker of the take
  std::vector<std::string> warnings;      ///< full sentences, also sent to ctx
};

/// Applies the rules in the order of SelectionReason. A pattern matches "label" or
/// "subject:label", any case. A name without wildcards in `include` is chosen whatever its kind;
/// a pattern in `include` other than a bare "*" chooses head-rig markers too. When every marker
/// that would be left has a head rig's name, none is taken for a rig (with a warning).
/// Throws UsageError for bad options and NoResultError when no marker is left.
MarkerSelectionResult select_markers(const MarkerSequence& take,
                                     const MarkerSelectionOptions& options = {},
                                     const RunContext& ctx = {});

}  // namespace kinemesh
