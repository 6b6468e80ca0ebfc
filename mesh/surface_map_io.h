// Files of surface maps, in one documented form per file type. The direction is source → target:
// entry v is the point of the target mesh that vertex v of the source mesh maps to. All indices
// count from 0; weights belong to corners 0, 1, 2 of the face and sum to 1.
//
// CSV:  # kinemesh surface map, source -> target
//       # source: NAME
//       # target: NAME
//       vertex,face,b0,b1,b2,confidence
//       0,411,0.25,0.5,0.25,0.93         one line per source vertex, ascending
//       1,-1,0,0,0,                      unmapped; confidence empty when not known
// JSON: {"format": "kinemesh surface map", "source": NAME, "target": NAME,
//        "points": [[face, b0, b1, b2], …], "confidence": [ … ]}   confidence may be missing
// NPZ:  face (int64, n), weights (float64, n × 3), confidence (float64, n; may be missing),
//       source, target (texts)
#pragma once

#include <filesystem>

#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

/// By extension: .csv, .json or .npz. The file appears whole or not at all, with every double
/// exact. Throws UsageError for another extension, InputError when it cannot be written.
void write_surface_map(const std::filesystem::path& path, const SurfaceMap& map);

/// Throws InputError naming the file and the line or entry for whatever is malformed: vertices out
/// of order, negative weights or weights whose sum is not 1 (1e-6), confidence outside [0, 1].
SurfaceMap read_surface_map(const std::filesystem::path& path);

/// Throws InputError naming the first vertex whose face does not exist in `target`, or when the
/// map has not one point per vertex of `source`.
void check_surface_map(const SurfaceMap& map, const Topology& source, const Topology& target);

}  // namespace kinemesh
