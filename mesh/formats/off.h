// OFF, the Object File Format of Geomview: vertices and faces as text; one frame a file.
//
// Read: [ST][C][N]OFF with or without that word, polygons, comments, colours (skipped).
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mesh/formats/mesh_data.h"

namespace kinemesh {

/// Throws InputError with the line; also for 4OFF, nOFF and binary files, which are not read.
MeshData decode_off(std::span<const std::byte> bytes, const std::string& name);
std::string encode_off(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options);

}  // namespace kinemesh
