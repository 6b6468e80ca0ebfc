// VTK's XML PolyData (.vtp) and ParaView's collections of them (.pvd).
//
// Written: points, polygons, point arrays `filled`, `uncertainty` and `vertex_name`, field arrays
// `TimeValue` (s) and `kinemesh` (the lines of mesh/formats/metadata.h); data appended raw, or as
// text with Encoding::ascii. A collection OUT.pvd has its frames in OUT_frames/OUT_####.vtp.
// Read: text, base64, appended base64 and raw, with and without zlib, either byte order; polygons
// and triangle strips; several pieces.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "mesh/formats/mesh_data.h"

namespace kinemesh {

/// Throws InputError with line or array.
MeshData decode_vtp(std::span<const std::byte> bytes, const std::string& name);
std::string encode_vtp(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options);

/// One entry of a collection.
struct PvdEntry {
  double timestep = 0.0;
  std::string file;  ///< relative to the collection
};
/// By time; of several parts only one is allowed. Throws InputError with the line.
std::vector<PvdEntry> decode_pvd(std::span<const std::byte> bytes, const std::string& name);

}  // namespace kinemesh
