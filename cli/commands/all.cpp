#include "cli/commands/commands.h"

namespace kinemesh::cli {

std::vector<CommandSpec> all_commands() {
  // One command a line, in the order of the help.
  // clang-format off
  return {
      convert_command(),
      animate_command(),
      batch_command(),
      info_command(),
      formats_command(),
      c3d_info_command(),
      c3d_check_command(),
      c3d_diff_command(),
      c3d_export_command(),
      c3d_quality_command(),
      c3d_process_command(),
      c3d_evaluate_fill_command(),
      geodesics_command(),
      align_command(),
      match_command(),
      correspond_command(),
      compare_command(),
      solve_matching_command(),
      deformation_command(),
      features_command(),
      evaluate_features_command(),
      evaluate_map_command(),
      retarget_command(),
      basis_command(),
      express_command(),
      hash_command(),
  };
  // clang-format on
}

std::string family_summary(std::string_view family) {
  if (family == "c3d") return "Inspect, check, grade, clean, compare and convert C3D sessions";
  if (family == "evaluate") return "Measure results against a known truth";
  throw InternalError("the command family '" + std::string(family) + "' has no summary");
}

}  // namespace kinemesh::cli
