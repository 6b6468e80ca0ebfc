// Geodesic distances and shortest paths on triangle meshes.
//
//   const GeodesicSolver solver(mesh);                       // once per mesh
//   GeodesicField field = solver.solve({vertex_point(topology, 17)});
//   field.distances[v];  solver.path_to(field, v).points;
//
// Exact: the polyhedral distance, by propagating windows over unfolded triangles in the order of
// their distance (Mitchell, Mount & Papadimitriou 1987; Chen & Han 1990; Xin & Wang 2009; bucket
// order as in Xu et al. 2015). Dijkstra: along edges, as the thesis uses. Heat: Crane,
// Weischedel & Wardetzky 2013 on the intrinsic Delaunay triangulation (Sharp, Soliman & Crane
// 2019). Degenerate triangles: mesh/geodesics/intrinsic_lengths.h. Non-manifold edges act as
// borders: paths run along them, but do not cross them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/mesh.h"
#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

/// The distance of what no path reaches, or only one longer than the radius asked for.
inline constexpr double unreachable = std::numeric_limits<double>::infinity();

enum class GeodesicMethod { exact, dijkstra, heat };

struct GeodesicOptions {
  GeodesicMethod method = GeodesicMethod::exact;
  double radius_mm = 0.0;  ///< search no further than this; 0: everywhere
  double heat_time = 1.0;  ///< diffusion time of the heat method, in squared mean edge lengths
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// The last straight stretch of a shortest path: from `origin` into the frame of `halfedge`.
/// In the solver's own numbering; only GeodesicSolver reads it.
struct GeodesicArrival {
  double x = 0.0, y = 0.0;
  HalfedgeIndex halfedge = invalid_index;
  uint32_t origin = invalid_index;
};

struct GeodesicDiagnostics {
  std::size_t windows = 0;           ///< windows propagated (exact method)
  std::size_t peak_windows = 0;      ///< most windows that waited at once
  std::size_t window_bytes = 0;      ///< memory of one window
  std::size_t degenerate_faces = 0;  ///< faces without area that were mended
};

struct GeodesicField {
  std::vector<double> distances;         ///< mm, one per vertex; `unreachable` where no path is
  std::vector<double> target_distances;  ///< mm, one per target asked for
  std::vector<uint32_t> nearest_source;  ///< per vertex, index into the sources or invalid_index;
                                         ///< empty for the heat method
  GeodesicDiagnostics diagnostics;
  GeodesicMethod method = GeodesicMethod::exact;
  std::vector<SurfacePoint> sources, targets;  ///< as asked for
  std::vector<GeodesicArrival> arrivals;       ///< per vertex, then per target
};

/// A shortest path from a source to a vertex or target: straight between its points, each of
/// which lies on an edge or is a vertex, but for the first and last.
struct GeodesicPath {
  std::vector<SurfacePoint> points;  ///< from the source on
  double length = 0.0;               ///< mm, the sum of its stretches
  uint32_t source = invalid_index;   ///< index into the sources
};

/// A vertex as a surface point. Throws UsageError when it does not exist or belongs to no face.
SurfacePoint vertex_point(const Topology& topology, VertexIndex v);
std::vector<SurfacePoint> vertex_points(const Topology& topology,
                                        std::span<const VertexIndex> vertices);

/// Distances on one mesh from any number of sources, one search after the other. Immutable and
/// safe to use from several threads; each search borrows a workspace that is kept for the next.
class GeodesicSolver {
 public:
  /// Throws InputError naming the vertex for positions that are not finite.
  GeodesicSolver(std::shared_ptr<const Topology> topology,
                 std::span<const Eigen::Vector3d> positions);
  GeodesicSolver(std::shared_ptr<const Topology> topology,
                 std::span<const Eigen::Vector3f> positions);
  explicit GeodesicSolver(const Mesh& mesh);
  GeodesicSolver(GeodesicSolver&&) noexcept;
  GeodesicSolver& operator=(GeodesicSolver&&) noexcept;
  ~GeodesicSolver();

  const Topology& topology() const;

  /// Distances of every vertex, and of `targets`, from the nearest of `sources`. Throws UsageError
  /// for a source or target that is no point of the mesh, and for no source at all.
  GeodesicField solve(const std::vector<SurfacePoint>& sources, const GeodesicOptions& options = {},
                      const RunContext& ctx = {},
                      const std::vector<SurfacePoint>& targets = {}) const;
  GeodesicField solve(VertexIndex source, const GeodesicOptions& options = {},
                      const RunContext& ctx = {}) const;

  /// Exact distances of every vertex from vertex or point `source`, written to `distances` (one
  /// per vertex): the quick form for many sources.
  void exact_distances(const SurfacePoint& source, std::span<double> distances,
                       double radius_mm = 0.0) const;
  void exact_distances(const SurfacePoint& source, std::span<float> distances,
                       double radius_mm = 0.0) const;

  /// The vertices within `radius_mm` of `source` with their exact distances, nearest first; its
  /// cost depends on what lies within, not on the size of the mesh.
  std::vector<std::pair<VertexIndex, double>> within(const SurfacePoint& source,
                                                     double radius_mm) const;

  /// The path behind field.distances[v] or field.target_distances[target]. Throws NoResultError
  /// when there is none, and UsageError for a field of the heat method.
  GeodesicPath path_to(const GeodesicField& field, VertexIndex v) const;
  GeodesicPath path_to_target(const GeodesicField& field, std::size_t target) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// One search on a mesh that is not used again.
GeodesicField geodesic_distances(const Mesh& mesh, const std::vector<SurfacePoint>& sources,
                                 const GeodesicOptions& options = {}, const RunContext& ctx = {});
/// The exact shortest path between two points. Throws NoResultError when they are not connected.
GeodesicPath shortest_path(const Mesh& mesh, const SurfacePoint& from, const SurfacePoint& to);

}  // namespace kinemesh
