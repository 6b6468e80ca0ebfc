// Wavefront OBJ: vertices and faces; one frame a file.
//
// Read: polygons, negative (relative) indices, v/vt/vn corners, lines continued with a backslash.
// Normals, texture coordinates, groups, materials, curves and colours are skipped. Written: 1-based
// triangles, and the lines of mesh/formats/metadata.h as comments.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mesh/formats/mesh_data.h"

namespace kinemesh {

/// Throws InputError with the line.
MeshData decode_obj(std::span<const std::byte> bytes, const std::string& name);
std::string encode_obj(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options);

}  // namespace kinemesh
