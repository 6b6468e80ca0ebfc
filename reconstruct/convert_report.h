// What a conversion says about itself as one HTML page: what came in, what is doubtful, the
// animated mesh to be turned and scrubbed, gaps, quality, and how to make it again.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "reconstruct/convert.h"

namespace kinemesh {

struct ConvertReportOptions {
  std::string title{};                 ///< "anna_happy.c3d"
  std::vector<std::string> outputs{};  ///< the files beside it, to be listed
  double mesh_max_error_mm = 0.0;      ///< of the files beside it; 0 when they keep every float
  double mesh_rms_error_mm = 0.0;
  std::optional<Eigen::Vector3f> up{};  ///< axis that points up; otherwise estimated
  std::size_t max_bytes = 3000000;      ///< of the page; the animation is compressed to fit
  std::size_t longest_list = 60;        ///< warnings, fills and markers beyond are counted
};

struct ConvertReport {
  std::string html;
  double max_error_mm = 0.0;  ///< of the animation on the page
  double rms_error_mm = 0.0;
};

/// The page; program, command, options and inputs are those of `result.animation.provenance`.
/// Throws NoResultError when it cannot be made to fit max_bytes.
ConvertReport convert_report(const MarkerSequence& session, const ConvertResult& result,
                             const ConvertReportOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
