// A one-to-one map of a closed surface without handles to the unit sphere that never folds.
//
// Coarse to fine: edges are collapsed until a tetrahedron is left, which is put on the sphere; the
// vertices come back in reverse order, each to the point of its ring's kernel that is farthest from
// the ring's edges (the kernel is never empty: the vertex that took its place sees the whole ring).
// Where the kernel is too narrow to be trusted in floating point, the neighbours are moved to the
// centres of theirs first. Between the levels every vertex descends the symmetric Dirichlet energy
// (Newton steps along the sphere; no step is taken that turns a triangle). After Praun & Hoppe 2003
// and Schmidt et al. 2023.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "analysis/spherical/orientation.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/topology.h"

namespace kinemesh {

struct SphericalOptions {
  double sphere_growth = 1.5;    ///< vertices of a level over those of the level before
  int sphere_sweeps = 3;         ///< descents of each vertex per level
  int sphere_final_sweeps = 20;  ///< at most, at the finest level
  double sphere_slenderness = 0.05;
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct SphericalMap {
  std::vector<Eigen::Vector3d> points;  ///< unit vectors, one per vertex
  SphereCheck check;                    ///< of `points`; always valid
  /// Mean over the surface of the symmetric Dirichlet energy / 4 of the map to the sphere of the
  /// same area: (σ₁² + σ₂² + σ₁⁻² + σ₂⁻²) / 4, 1 where it is isometric. Faces without area count
  /// nothing; faces thinner than options.sphere_slenderness count as if they were that thick.
  double distortion = 0.0;
  std::size_t withdrawals = 0;  ///< vertices whose ring had to be re-centred before they came back
  std::size_t sweeps = 0;       ///< at the finest level
};

/// Throws NoResultError, which says what is wrong and what to do, for a surface that is not one
/// closed manifold component of genus 0 or has no area, and when no map without folds is found;
/// InputError naming the vertex for positions that are not finite.
SphericalMap map_to_sphere(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                           const SphericalOptions& options = {}, const RunContext& ctx = {});

/// The NoResultError of map_to_sphere for surfaces that have no such map, whatever their shape.
void require_closed_genus_zero(const Topology& topology);

}  // namespace kinemesh
