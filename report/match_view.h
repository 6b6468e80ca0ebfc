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
  std::string source_name, target_name;  ///< below the surfaces
};

struct MatchLine {
  Eigen::Vector3f source, target;        ///< mm, on the surfaces
  std::string source_text, target_text;  ///< beside the dots
};

/// Both surfaces from the front at the same size, with a line for each match, in turning colours
/// from the top, and a grey dot where there is none. What lies behind the surface is a
/// ring, and its line is dashed.
Canvas draw_matches(const Mesh& source, const Mesh& target, const std::vector<MatchLine>& matches,
                    const std::vector<Eigen::Vector3f>& unmatched_source,
                    const std::vector<Eigen::Vector3f>& unmatched_target,
                    const MatchViewOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
