// Error curves of maps as a chart.
#pragma once

#include <string>
#include <vector>

#include "analysis/map_evaluation.h"
#include "report/chart.h"

namespace kinemesh {

/// Share of the places over the error up to `cutoff`, a curve for each map; dashed what an
/// evaluation has against the nearer of the truth and its mirror image.
LineChart error_curves(const std::vector<std::string>& names,
                       const std::vector<MapEvaluation>& evaluations, double cutoff);

}  // namespace kinemesh
