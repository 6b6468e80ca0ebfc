// One way in for every recording: C3D, TRC, our own CSV, and the exports of Motive and QTM.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "capture/c3d/reader.h"
#include "capture/c3d/summary.h"
#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

enum class SessionFormat { c3d, trc, csv, motive, qtm };

/// "C3D", "TRC", "Kinemesh CSV", "Motive CSV", "QTM TSV".
std::string_view name_of(SessionFormat format);

struct SessionReadOptions {
  C3dReadOptions c3d;  ///< its zero_points holds for the text formats too

  void declare(ParameterSet& p);
  /// Throws UsageError.
  void validate() const;
};

/// Decides by the file's content; its extension counts only where that says nothing. Throws
/// InputError naming the formats that are read when it is none of them.
SessionFormat detect_session_format(const std::filesystem::path& path);

/// Reads a session of any format. What a C3D file deviates in, and what a table leaves doubtful,
/// goes to ctx as warnings. Throws InputError naming file, place and remedy.
MarkerSequence read_session(const std::filesystem::path& path,
                            const SessionReadOptions& options = {}, const RunContext& ctx = {});

struct SessionSummaryResult {
  C3dSummary summary;
  std::vector<C3dFinding> findings;  ///< of a C3D file
};

/// Reads a session and sums up what it holds. Errors and warnings as read_session().
SessionSummaryResult summarise_session(const std::filesystem::path& path,
                                       const SessionReadOptions& options = {},
                                       const RunContext& ctx = {});

}  // namespace kinemesh
