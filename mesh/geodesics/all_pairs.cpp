#include "mesh/geodesics/all_pairs.h"

#include <algorithm>
#include <string>

#include "config/error.h"
#include "config/output_file.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

/// Header of NumPy's format 1.0, padded to a multiple of 64 bytes.
std::string npy_header(std::size_t rows, std::size_t columns) {
  std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(rows) +
                     ", " + std::to_string(columns) + "), }";
  constexpr std::size_t preamble = 10;
  text.append(63 - (preamble + text.size()) % 64, ' ');
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(text.size() & 0xFF);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

}  // namespace

std::vector<SurfacePoint> all_vertex_points(const Topology& topology) {
  if (topology.isolated_vertex_count() > 0) {
    throw InputError({.what = std::to_string(topology.isolated_vertex_count()) +
                              " vertices of the mesh belong to no face",
                      .remedy = "Remove them, or name the vertices to measure from"});
  }
  std::vector<SurfacePoint> points;
  points.reserve(topology.vertex_count());
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    points.push_back(vertex_point(topology, v));
  }
  return points;
}

void for_each_distance_row(const GeodesicSolver& solver, std::span<const SurfacePoint> sources,
                           const DistanceSink& sink, std::size_t chunk, double radius_mm,
                           const RunContext& ctx) {
  const std::size_t columns = solver.topology().vertex_count();
  chunk = std::clamp<std::size_t>(chunk, 1, std::max<std::size_t>(sources.size(), 1));
  DistanceMatrix rows(static_cast<Eigen::Index>(chunk), static_cast<Eigen::Index>(columns));
  for (std::size_t first = 0; first < sources.size(); first += chunk) {
    const std::size_t count = std::min(chunk, sources.size() - first);
    parallel_for(ctx, count, 1, [&](std::size_t i) {
      float* row = rows.data() + i * columns;
      solver.exact_distances(sources[first + i], std::span<float>(row, columns), radius_mm);
    });
    sink(first, rows.topRows(static_cast<Eigen::Index>(count)));
    ctx.progress(static_cast<double>(first + count) / static_cast<double>(sources.size()));
  }
}

DistanceMatrix distance_matrix(const GeodesicSolver& solver, std::span<const SurfacePoint> sources,
                               const RunContext& ctx, std::size_t max_bytes) {
  const std::size_t columns = solver.topology().vertex_count();
  if (columns > 0 && sources.size() > max_bytes / sizeof(float) / columns) {
    const std::size_t megabytes = sources.size() * columns / (1U << 20U) * sizeof(float);
    throw NoResultError({.what = "the distances from " + std::to_string(sources.size()) +
                                 " sources to " + std::to_string(columns) +
                                 " vertices would take " + std::to_string(megabytes) + " MB",
                         .remedy = "Write them to a file, or measure from fewer vertices"});
  }
  DistanceMatrix result(static_cast<Eigen::Index>(sources.size()),
                        static_cast<Eigen::Index>(columns));
  parallel_for(ctx, sources.size(), 1, [&](std::size_t i) {
    solver.exact_distances(sources[i], std::span<float>(result.data() + i * columns, columns));
  });
  return result;
}

void write_distance_matrix(const std::filesystem::path& path, const GeodesicSolver& solver,
                           std::span<const SurfacePoint> sources, const RunContext& ctx) {
  OutputFile file(path);
  file.write(npy_header(sources.size(), solver.topology().vertex_count()));
  for_each_distance_row(
      solver, sources,
      [&](std::size_t, const Eigen::Ref<const DistanceMatrix>& rows) {
        for (Eigen::Index i = 0; i < rows.rows(); ++i) {
          file.write(
              std::span<const float>(rows.row(i).data(), static_cast<std::size_t>(rows.cols())));
        }
      },
      256, 0.0, ctx);
  file.commit();
}

}  // namespace kinemesh
