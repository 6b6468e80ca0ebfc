// STL: loose triangles, ascii or binary; read only. Corners at exactly the same position become
// one vertex, in order of their first appearance; normals and attributes are skipped.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mesh/formats/mesh_data.h"

namespace kinemesh {

/// Throws InputError with the line (ascii) or byte (binary).
MeshData decode_stl(std::span<const std::byte> bytes, const std::string& name);

}  // namespace kinemesh
