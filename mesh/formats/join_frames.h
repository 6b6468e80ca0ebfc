// Several files of one frame each, as one animation.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "config/run_context.h"
#include "mesh/formats/mesh_data.h"

namespace kinemesh {

/// True when the faces are the same but for how polygons are cut, which depends on the positions.
bool same_faces(const MeshData& first, const MeshData& other);

/// All frames in one MeshData, in the unit of the first, from which everything that is said once
/// is taken too. `load(i)` is called in parallel; `name(i)` is for errors. Throws InputError when
/// a frame's topology differs from the first one's.
MeshData join_frames(std::size_t count, const std::function<MeshData(std::size_t)>& load,
                     const std::function<std::string(std::size_t)>& name, const RunContext& ctx);

}  // namespace kinemesh
