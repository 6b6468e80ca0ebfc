// Surfaces side by side with a value over each, in one camera: results beside the truth, an error
// map in mm, markers on a scan.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "config/run_context.h"
#include "mesh/mesh.h"
#include "report/canvas.h"
#include "report/mesh_view.h"

namespace kinemesh {

struct ErrorPanel {
  std::string caption;
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3f> positions;
  std::vector<float> values;         ///< empty: plain; else one per vertex, on the common scale
  std::vector<SceneSphere> spheres;  ///< markers
};

struct ErrorViewOptions {
  std::string title, subtitle;
  std::string value_label = "error";
  double high_mm = 0.0;  ///< upper end of the colour scale; 0: the largest value
  std::size_t columns = 3;
};

/// All panels from the front, at one scale, with a colour bar in mm when one has values or
/// `high_mm` is given. Throws NoResultError without panels.
Canvas draw_error_view(const std::vector<ErrorPanel>& panels, const ErrorViewOptions& options,
                       const RunContext& ctx = {});

}  // namespace kinemesh
