// Files of one stem that belong together: x.ply and x.pc2, x.gltf and x.bin, x.pvd and its frames.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "mesh/formats/registry.h"

namespace kinemesh {

/// The existing file named like `path` but for its extension: `extension` (lower case, with the
/// dot), or the same in capitals.
std::optional<std::filesystem::path> file_beside(const std::filesystem::path& path,
                                                 const std::string& extension);

/// What `format` reads together with `path`: the geometry of a point cache, the buffers of a glTF
/// file, the frames of a PVD collection. Throws InputError when a collection cannot be read.
std::vector<std::filesystem::path> files_read_with(const Format& format,
                                                   const std::filesystem::path& path);

/// Existing point caches that are read together with the mesh file `path`.
std::vector<std::filesystem::path> caches_beside(const FormatRegistry& formats,
                                                 const std::filesystem::path& path);

}  // namespace kinemesh
