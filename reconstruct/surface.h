// One manifold surface through all points of a cloud, without looking at motion.
#pragma once

#include <string>

#include "config/run_context.h"
#include "reconstruct/edge_constraints.h"
#include "reconstruct/edit_mesh.h"
#include "reconstruct/marker_spacing.h"

namespace kinemesh {

struct SurfaceOptions {
  double edge_bound = 2.2;  ///< of the advancing front, in marker spacings
  double rim_bound = 1.8;   ///< of the rim, in marker spacings
  double hole_bound = 4.0;  ///< of the fill of a hole, in marker spacings
  EdgeConstraints constraints;
};

struct Surface {
  EditMesh mesh{0};
  MarkerSpacing spacing;
  std::string method;  ///< "advancing front", "sphere chart" or "plane chart"
  double bound = 0.0;  ///< edge bound that was used, in h
  std::size_t inserted = 0, holes_filled = 0, rim_faces_trimmed = 0, flips = 0;
  double outwardness = 0.0;
  EdgeConstraints unmet;  ///< constraints that the mesh does not allow
};

/// All points become vertices of one manifold component of genus 0, outwards, Delaunay by arc
/// lengths, without a long rim edge. Points in canonical pose (canonical_pose.h) give a result
/// that depends on their shape alone. Throws NoResultError for points on a line.
Surface reconstruct_surface(const Points& points, const SurfaceOptions& options,
                            const RunContext& ctx = {});

}  // namespace kinemesh
