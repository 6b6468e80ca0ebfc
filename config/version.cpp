#include "config/version.h"

#include "kinemesh_commit.h"  // generated at build time

namespace kinemesh {

std::string version_number() { return KINEMESH_VERSION; }

std::string version_commit() { return KINEMESH_COMMIT; }

std::string program_version() {
  return "kinemesh " + version_number() + " (" + version_commit() + ")";
}

}  // namespace kinemesh
