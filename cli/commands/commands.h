// The subcommands; each is defined in the file of its name.
#pragma once

#include "cli/command.h"

namespace kinemesh::cli {

CommandSpec c3d_check_command();
CommandSpec c3d_diff_command();
CommandSpec c3d_evaluate_fill_command();
CommandSpec c3d_export_command();
CommandSpec c3d_info_command();
CommandSpec c3d_process_command();
CommandSpec c3d_quality_command();
CommandSpec convert_command();
CommandSpec geodesics_command();
CommandSpec hash_command();

}  // namespace kinemesh::cli
