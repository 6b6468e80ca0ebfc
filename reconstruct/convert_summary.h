// What a conversion says about itself: a text for the operator, JSON for programs, charts.
#pragma once

#include <string>
#include <vector>

#include "reconstruct/convert.h"
#include "report/gap_chart.h"

namespace kinemesh {

/// A page of plain text: what came in, what was measured, what was filled, what is doubtful.
std::string summary_text(const MarkerSequence& session, const ConvertResult& result);

/// The same and more as a JSON document; its fields are documented in docs/convert.md.
/// `outputs` are the paths of the files written.
std::string summary_json(const MarkerSequence& session, const ConvertResult& result,
                         const std::vector<std::string>& outputs);

/// CSV: frame, time_s, flipped, degenerate, stretch_min, stretch_max, stretch_rms, filled.
std::string quality_csv(const ConvertResult& result);

/// When which marker was missing, and how it was filled.
GapChart gap_chart_of(const ConvertResult& result);

/// Sentences about what should be looked at before the mesh is trusted; empty when nothing is.
std::vector<std::string> doubts_of(const ConvertResult& result);

}  // namespace kinemesh
