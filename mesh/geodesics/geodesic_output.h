// Files of geodesic distances and paths.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "config/output_file.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/mesh.h"

namespace kinemesh {

/// Where the paths go that belong to the distances in `path`: NAME_path beside it.
std::filesystem::path path_file(const std::filesystem::path& path);
/// Throws UsageError unless the extension is .csv, .npz, .ply or .png (drawn elsewhere).
void check_distance_path(const std::filesystem::path& path);

/// Adds to `files`, by the extension of `path`:
///   .csv  `vertex,distance`, one line per vertex from 0, "inf" where no path leads;
///         paths: NAME_path.csv, `path,x,y,z,face,b0,b1,b2`, from source to end
///   .ply  the mesh with the distance of every vertex as the property `quality` (float; inf);
///         paths: NAME_path.ply, points and edges
///   .npz  distances (float64), nearest_source (int64), sources (face, b0, b1, b2), path_points
///         (n × 3), path_faces, path_weights (n × 3), path_starts (first point of each path)
/// Throws like check_distance_path().
void add_distance_files(OutputSet& files, const std::filesystem::path& path, const Mesh& mesh,
                        const GeodesicField& field, std::span<const GeodesicPath> paths);

}  // namespace kinemesh
