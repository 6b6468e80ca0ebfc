// What a GeodesicSolver keeps. Internal to mesh/geodesics.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/heat_method.h"
#include "mesh/geodesics/path_tracing.h"
#include "mesh/geodesics/unfolded_mesh.h"
#include "mesh/geodesics/window_propagation.h"

namespace kinemesh {

struct GeodesicSolver::Data {
  Data(std::shared_ptr<const Topology> t, std::span<const Eigen::Vector3d> p)
      : topology(std::move(t)), positions(p.begin(), p.end()), mesh(*topology, positions) {
    for (VertexIndex v = 0; v < topology->vertex_count(); ++v)
      inner.push_back(mesh.inner_vertex(v));
  }

  /// A workspace, borrowed until it is destroyed.
  class Loan {
   public:
    explicit Loan(Data& data) : data_(data) {
      const std::lock_guard lock(data_.mutex);
      if (!data_.workspaces.empty()) {
        workspace_ = std::move(data_.workspaces.back());
        data_.workspaces.pop_back();
      } else {
        workspace_ = std::make_unique<geodesics::WindowPropagation>(data_.mesh);
      }
    }
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    ~Loan() {
      const std::lock_guard lock(data_.mutex);
      data_.workspaces.push_back(std::move(workspace_));
    }
    geodesics::WindowPropagation* operator->() { return workspace_.get(); }

   private:
    Data& data_;
    std::unique_ptr<geodesics::WindowPropagation> workspace_;
  };

  void solve_exact(GeodesicField& field, double radius, const RunContext& ctx);
  void solve_dijkstra(GeodesicField& field, double radius, const RunContext& ctx);
  void solve_heat(GeodesicField& field, const GeodesicOptions& options, const RunContext& ctx);
  void name_nearest_sources(GeodesicField& field) const;
  GeodesicPath trace(const GeodesicField& field, GeodesicArrival arrival, double distance,
                     const SurfacePoint& end, VertexIndex at) const;
  VertexIndex straight_stretch(const GeodesicField& field, const GeodesicArrival& arrival,
                               VertexIndex at, std::vector<SurfacePoint>& points) const;
  VertexIndex pass_vertex(const GeodesicField& field, const geodesics::TraceEnd& traced,
                          std::vector<SurfacePoint>& points) const;
  double detour_of(const GeodesicField& field, const std::vector<SurfacePoint>& points,
                   std::size_t begin, VertexIndex next, double distance) const;
  struct Neighbour {
    VertexIndex vertex;  // original
    double way;          // over it to the nearest source
  };
  Neighbour nearest_beside(const GeodesicField& field, VertexIndex at, const SurfacePoint& point,
                           const std::set<VertexIndex>& passed) const;
  std::optional<VertexIndex> way_beside(const GeodesicField& field, VertexIndex at,
                                        std::size_t begin, double way,
                                        const std::set<VertexIndex>& passed,
                                        std::vector<SurfacePoint>& points) const;
  uint32_t finish_along_edges(const GeodesicField& field, VertexIndex at,
                              std::vector<SurfacePoint>& points) const;
  void measure(GeodesicPath& path) const;
  void check_field(const GeodesicField& field, std::size_t index, std::size_t count) const;
  template <class Scalar>
  void quick_exact(const SurfacePoint& source, std::span<Scalar> distances, double radius_mm);

  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> positions;
  geodesics::UnfoldedMesh mesh;
  std::vector<VertexIndex> inner;  // by original vertex
  std::mutex mutex;
  std::vector<std::unique_ptr<geodesics::WindowPropagation>> workspaces;
  std::shared_ptr<const HeatMethod> heat;
  double heat_time = 0.0;
};

}  // namespace kinemesh
