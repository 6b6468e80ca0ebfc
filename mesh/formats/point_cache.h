// Point caches: positions of all frames in one file, faces in another of the same stem.
//
// PC2 (Point Cache 2): "POINTCACHE2\0", int32 version 1, int32 vertices, float start, float
// sampling (frames per sample), int32 frames, then frames × vertices × 3 float32, little-endian.
// MDD (LightWave, Maya): int32 frames, int32 vertices, frames × float32 time in s, then
// frames × vertices × 3 float32, big-endian.
//
// Written beside a .ply of the first frame with the faces, vertex names, unit, rate, events,
// filled flags and provenance; read beside a .ply, .obj or .off, or alone as points without faces.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "mesh/formats/mesh_data.h"

namespace kinemesh {

/// Positions alone. Throws InputError naming the byte.
MeshData decode_pc2(std::span<const std::byte> bytes, const std::string& name);
MeshData decode_mdd(std::span<const std::byte> bytes, const std::string& name);

/// As above straight from the file into the positions, without a second copy in memory.
MeshData read_pc2_positions(const std::filesystem::path& path);
MeshData read_mdd_positions(const std::filesystem::path& path);

}  // namespace kinemesh
