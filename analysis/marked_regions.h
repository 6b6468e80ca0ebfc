// Regions of a surface marked by hand (Mykhalchuk 2015, 4.9.2).
#pragma once

#include <filesystem>
#include <vector>

namespace kinemesh {

/// The share of the files in which each of `vertex_count` vertices is marked. A file is JSON, a
/// list of vertices or lists of vertices (from 0), perhaps under the key "regions"; or a PLY with
/// vertex colours, in which every vertex that is not grey is marked. Throws InputError naming file
/// and place.
std::vector<double> read_marked_regions(const std::vector<std::filesystem::path>& files,
                                        std::size_t vertex_count);

}  // namespace kinemesh
