// The subcommands; each is defined in the file of its name.
#pragma once

#include "cli/command.h"

namespace kinemesh::cli {

CommandSpec hash_command();

}  // namespace kinemesh::cli
