// What commands that write several files share: the names beside an output, and what the files say
// about how they were made.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/animated_mesh.h"

namespace kinemesh {

/// `out/face` for out/face.ply, out/face_####.obj and the folder out/face/.
std::filesystem::path stem_of_output(const std::filesystem::path& output);

/// `out/face` and `_summary.json` make out/face_summary.json.
std::filesystem::path beside(const std::filesystem::path& stem, const std::string& suffix);

/// Program, command and options as given; the inputs with their hashes, those left out that are
/// empty or no files.
Provenance provenance_of(const std::string& program, const std::string& command,
                         const std::string& options_toml,
                         const std::vector<std::filesystem::path>& inputs);

}  // namespace kinemesh
