// What a performance does relative to its rest pose. Private to analysis/comparison.
#pragma once

#include "analysis/comparison/comparison.h"

namespace kinemesh::comparison {

/// The mean over the first `seconds` (at least one frame).
std::vector<Eigen::Vector3d> rest_of(const AnimatedMesh& mesh, double seconds);

/// Displacement and strain of every frame; strain only where there is motion (`deformation`).
Course course_of(const AnimatedMesh& mesh, std::vector<Eigen::Vector3d> rest,
                 const DeformationResult* deformation, const DeformationOptions& options);

/// A field of `values` per vertex of B at A's vertices and frames: `frames[f]` is B's (fractional)
/// frame at A's f; `channels` values a vertex. NaN where the map leads nowhere.
Field brought_to(const Field& of_b, std::size_t channels, const SurfaceMap& forward,
                 const Topology& topology_b, const std::vector<double>& frames);

}  // namespace kinemesh::comparison
