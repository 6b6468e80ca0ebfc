// Exact distances from many sources: to memory, to a file, or chunk by chunk to whoever wants them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "config/run_context.h"
#include "mesh/geodesics/geodesics.h"

namespace kinemesh {

/// sources × vertices, mm; `unreachable` where no path is.
using DistanceMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// All vertices as sources. Vertices without faces are no points of the surface: InputError.
std::vector<SurfacePoint> all_vertex_points(const Topology& topology);

/// Called with the first source of a chunk and its rows, in ascending order, one at a time.
using DistanceSink =
    std::function<void(std::size_t first, const Eigen::Ref<const DistanceMatrix>& rows)>;

/// Searches from every source, in parallel, holding at most `chunk` rows at once. The result does
/// not depend on the number of threads. A radius above 0 truncates each search.
void for_each_distance_row(const GeodesicSolver& solver, std::span<const SurfacePoint> sources,
                           const DistanceSink& sink, std::size_t chunk = 256,
                           double radius_mm = 0.0, const RunContext& ctx = {});

/// All rows in memory. Throws NoResultError, which names the size and the remedy, when they would
/// take more than `max_bytes`.
DistanceMatrix distance_matrix(const GeodesicSolver& solver, std::span<const SurfacePoint> sources,
                               const RunContext& ctx = {},
                               std::size_t max_bytes = std::size_t{4} << 30);

/// All rows to a NumPy file (.npy, float32, C order), written whole or not at all, in bounded
/// memory. Throws InputError when it cannot be written.
void write_distance_matrix(const std::filesystem::path& path, const GeodesicSolver& solver,
                           std::span<const SurfacePoint> sources, const RunContext& ctx = {});

}  // namespace kinemesh
