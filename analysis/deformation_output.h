// Files of deformation characteristics.
#pragma once

#include <filesystem>

#include "analysis/deformation.h"
#include "config/output_file.h"

namespace kinemesh {

/// Adds to `files`, by the extension of `path`:
///   .npz  deformation (float32, vertices × frames), rest (float64, vertices × 3, mm), time_s,
///         and direction (float32, vertices × frames × 3) when it was asked for
///   .csv  `vertex,0,1,…`: one line per vertex, a column per frame (all counted from 0)
///   .pvd  a ParaView collection of NAME_####.vtp, the point array `deformation` in each frame
///   .ply  NAME_####.ply: each frame coloured (viridis, one scale for all), `quality` the value
/// Throws UsageError for another extension.
void add_deformation_files(OutputSet& files, const std::filesystem::path& path,
                           const AnimatedMesh& animation, const DeformationResult& deformation,
                           const RunContext& ctx = {});

/// Upper end of the colours: the 99.5th percentile of all values.
double colour_limit(const DeformationResult& deformation);

}  // namespace kinemesh
