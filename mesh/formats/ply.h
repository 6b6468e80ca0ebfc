// PLY (Turk 1994): ascii and both binary byte orders.
//
// Unknown elements, properties and comments are skipped; faces may be polygons, triangle strips
// are read too. Kept beside the shape: everything of mesh/formats/metadata.h in comments, and per
// vertex `filled` (uchar) and `uncertainty` (float), which other programs ignore.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mesh/formats/mesh_data.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/options.h"

namespace kinemesh {

/// Throws InputError with the line (header, ascii) or byte (binary).
MeshData decode_ply(std::span<const std::byte> bytes, const std::string& name);

/// One frame as the content of a PLY file. The first frame of a mesh carries its full description.
std::string encode_ply(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options);

/// As above with other comments, as PLY + PC2 needs.
std::string encode_ply(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options,
                       const MetadataChoice& comments);

}  // namespace kinemesh
