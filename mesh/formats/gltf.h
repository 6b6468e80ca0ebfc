// glTF 2.0 (Khronos, 2021) and GLB: the mesh in metres with Y up, its motion as morph targets.
//
// Written: positions, normals (of the first frame), indices, vertex colours on request, one morph
// target per mode and one animation of their weights (mesh/formats/morph_animation.h); rate, frame
// count, errors reached and the lines of mesh/formats/metadata.h under asset.extras.kinemesh. No
// extensions, so every viewer plays it. `.gltf` has its data in a `.bin` of the same stem.
// Read: triangles of all nodes of the scene with their transforms, morph targets and the first
// animation of their weights (linear, step or cubic), sparse accessors, data URIs; materials,
// skins and moving nodes are left out with a warning. Z points up afterwards, unless the file says
// that our data had Y up.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "mesh/formats/mesh_data.h"
#include "mesh/formats/registry.h"

namespace kinemesh {

/// Played at this rate when neither the mesh nor the file says its own.
inline constexpr double assumed_rate_hz = 30.0;

/// JSON text and binary buffer.
struct GltfContent {
  std::string json;
  std::string binary;
  WriteReport report;
};

/// `buffer_uri` is empty for GLB. Throws NoResultError as morph_animation_of does.
GltfContent encode_gltf(const AnimatedMesh& mesh, const WriteOptions& options,
                        const std::string& buffer_uri, const RunContext& ctx);

/// A GLB file, or a glTF file whose buffers are data URIs. Throws InputError.
MeshData decode_gltf(std::span<const std::byte> bytes, const std::string& name);
/// As above; `load` gives the bytes of a buffer's file.
MeshData decode_gltf(std::span<const std::byte> bytes, const std::string& name,
                     const std::function<std::string(const std::string& uri)>& load);

/// The file that a buffer's relative URI names: %20 becomes a blank.
std::string decoded_uri(const std::string& uri);

}  // namespace kinemesh
