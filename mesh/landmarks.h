// Landmarks in text files: places named by hand, and the truth of the usual benchmarks.
//
// Vertex lists: one vertex a line, line k of one mesh's file belonging to line k of the other's.
// `.vts` files (Ren et al. 2018) count from 1, all others (.pinned, .lmk, .txt, …) from 0.
// Pairs: one pair a line, the place on the source and the place on the target, then a name if any,
// separated by commas or blanks: `120,987,nose tip`. A place is a vertex, counted from 0, or a
// point inside a face as FACE:B0:B1:B2. Lines that start with # and a first line of column names
// are passed over in both.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

/// A vertex or FACE:B0:B1:B2; weights are made to sum to 1. Nothing when the text names no point
/// of the mesh.
std::optional<SurfacePoint> parse_place(std::string_view text, const Topology& topology);

/// Throws InputError naming file and line.
std::vector<VertexIndex> read_vertex_list(const std::filesystem::path& path,
                                          std::size_t vertex_count);

/// A place of the source and the place of the target that belongs to it.
struct LandmarkPair {
  SurfacePoint source, target;
  std::string name;  ///< may be empty
};
/// Throws InputError naming file and line.
std::vector<LandmarkPair> read_landmark_pairs(const std::filesystem::path& path,
                                              const Topology& source, const Topology& target);

}  // namespace kinemesh
