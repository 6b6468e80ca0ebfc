// Approximate geodesic distances by diffusion: two sparse solves a source after one factorisation
// (Crane, Weischedel & Wardetzky 2013), on the intrinsic Delaunay triangulation.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

class HeatMethod {
 public:
  /// Factorises once. `time` is the diffusion time in squared mean edge lengths of the intrinsic
  /// triangulation. Throws InputError for positions that are not finite, and NoResultError when
  /// the mesh is too ill-shaped to factorise.
  HeatMethod(const Topology& topology, std::span<const Eigen::Vector3d> positions,
             double time = 1.0);
  HeatMethod(HeatMethod&&) noexcept;
  ~HeatMethod();

  /// Distance of every vertex from the nearest source; infinite in components without one and for
  /// vertices without faces. Safe to call from several threads.
  std::vector<double> distances(std::span<const SurfacePoint> sources) const;

 private:
  struct System;
  std::unique_ptr<const System> system_;
};

}  // namespace kinemesh
