// A coarser mesh of a scan, to solve on what the scan itself is too large for, and the way back:
// shortest edges are collapsed first, so that the coarse mesh is alike everywhere, and no edge
// leaves a boundary loop: lips and lids stay apart (Hoppe 1996; CGAL's edge collapse).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <span>
#include <vector>

#include "config/run_context.h"
#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh {

struct CoarseScan {
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> positions;  ///< mm
  /// One per vertex of the scan: its closest point among the faces around the coarse vertex that
  /// it was collapsed into, so that it stays on its own lip; invalid for vertices without faces.
  std::vector<SurfacePoint> places;

  /// vertices of the scan × coarse vertices, rows sum to 1: carries values to the scan.
  Eigen::SparseMatrix<double> carry() const;
};

/// Collapses edges until `faces` are left or the shortest edge is longer than `longest_edge_mm`.
/// Faces on edges that are not manifold are passed over. Throws InputError for positions that are
/// not finite.
CoarseScan coarsen_scan(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                        std::size_t faces, double longest_edge_mm, const RunContext& ctx = {});

}  // namespace kinemesh
