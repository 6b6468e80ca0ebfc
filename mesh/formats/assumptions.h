// What is taken for granted about a file that was read.
#pragma once

#include <string>
#include <vector>

#include "mesh/formats/mesh_io.h"

namespace kinemesh {

/// Sentences about unit and rate where `file` does not say them and `options` neither, or where
/// `options` say otherwise than the file, which is believed.
std::vector<std::string> assumptions_of(const AnimationFile& file, const std::string& name,
                                        const ReadOptions& options);

}  // namespace kinemesh
