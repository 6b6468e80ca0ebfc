// A picture of two surfaces side by side with lines between what belongs together.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "config/run_context.h"
#include "mesh/mesh.h"
#include "report/canvas.h"

namespace kinemesh {

struct MatchViewOptions {
  std::string title = "Matches";
  std::string subtitle;
};

/// One match, or a place without one (the other side not finite).
struct MatchLine {
  Eigen::Vector3f source, target;  ///< mm, on the surfaces
};

/// Both surfaces from the front at the same size, a line of its own colour for each match, and a
/// grey dot where there is none.
Canvas draw_matches(const Mesh& source, const Mesh& target, const std::vector<MatchLine>& matches,
                    const std::vector<Eigen::Vector3f>& unmatched_source,
                    const std::vector<Eigen::Vector3f>& unmatched_target,
                    const MatchViewOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
