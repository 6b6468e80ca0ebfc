// Which Kinemesh this is.
#pragma once

#include <string>

namespace kinemesh {

/// "0.1.0"
std::string version_number();
/// Abbreviated commit, with "+changes" when the tree was not clean; "unknown" outside git.
std::string version_commit();
/// "kinemesh 0.1.0 (1a2b3c4)", for provenance.
std::string program_version();

}  // namespace kinemesh
