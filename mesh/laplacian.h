// The Laplace operator of a surface by linear finite elements on its intrinsic Delaunay
// triangulation (Bobenko & Springborn 2007): no negative weights however ill-shaped the triangles,
// and free edges stay free, so that nothing crosses between lips or lids.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "mesh/surface_measures.h"
#include "mesh/topology.h"

namespace kinemesh {

struct SurfaceOperators {
  /// vertices × vertices, symmetric, positive semidefinite, rows sum to 0: uᵀ S u is the Dirichlet
  /// energy of u, without unit.
  Eigen::SparseMatrix<double> stiffness;
  Eigen::VectorXd masses;  ///< mm², a third of the triangles around each vertex; always above 0
};

/// Throws InputError for positions that are not finite.
SurfaceOperators surface_operators(const Topology& topology,
                                   std::span<const Eigen::Vector3d> positions);

}  // namespace kinemesh
