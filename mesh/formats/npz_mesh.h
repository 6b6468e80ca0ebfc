// An animated mesh as a NumPy archive, for Python: numpy.load("face.npz")["positions"].
//
//   positions     float32, frames × vertices × 3 (read also: float64, and vertices × 3)
//   faces         int32, faces × 3, 0-based (read also: int64)
//   vertex_names  text, one per vertex; left out when there are none
//   rate_hz       float64; unit: text ("mm"); first_frame: float64
//   filled        bool, frames × vertices; uncertainty: float32, alike; left out when not known
//   kinemesh      text: the lines of mesh/formats/metadata.h
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mesh/formats/mesh_data.h"

namespace kinemesh {

/// Throws InputError naming the array.
MeshData decode_npz(std::span<const std::byte> bytes, const std::string& name);
std::string encode_npz(const AnimatedMesh& mesh, const WriteOptions& options);

}  // namespace kinemesh
