// The subcommands; each is defined in the file of its name.
#pragma once

#include "cli/command.h"

namespace kinemesh::cli {

CommandSpec align_command();
CommandSpec animate_command();
CommandSpec basis_command();
CommandSpec batch_command();
CommandSpec c3d_check_command();
CommandSpec c3d_diff_command();
CommandSpec c3d_evaluate_fill_command();
CommandSpec c3d_export_command();
CommandSpec c3d_info_command();
CommandSpec c3d_process_command();
CommandSpec c3d_quality_command();
CommandSpec compare_command();
CommandSpec convert_command();
CommandSpec correspond_command();
CommandSpec deformation_command();
CommandSpec evaluate_features_command();
CommandSpec evaluate_map_command();
CommandSpec express_command();
CommandSpec features_command();
CommandSpec geodesics_command();
CommandSpec formats_command();
CommandSpec hash_command();
CommandSpec info_command();
CommandSpec match_command();
CommandSpec retarget_command();
CommandSpec solve_matching_command();

}  // namespace kinemesh::cli
