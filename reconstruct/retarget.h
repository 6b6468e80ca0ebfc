// Deformation transfer (Sumner & Popović 2004): the motion of one subject's mesh on another's, in
// the form of a Poisson equation for vertex positions (Botsch, Sumner, Pauly & Gross 2006), which
// has the same minimum: with target triangles t of area A_t and the deformation gradient S of the
// source triangle that each corresponds to,
//
//   min over x of  Σ_t A_t ‖∇x − S_t‖²      →      (Gᵀ A G) x = Gᵀ A S
//
// Gᵀ A G is the cotangent Laplacian of the target at rest: one sparse Cholesky factorisation serves
// all frames, three right-hand sides each. Positions are free up to a translation of each
// component, which is taken from the source's least moving parts.
#pragma once

#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/mesh.h"
#include "mesh/surface_point.h"

namespace kinemesh {

struct RetargetResult {
  AnimatedMesh animation;                ///< on the target's topology
  double scale = 1.0;                    ///< target size over source size, for translations
  std::size_t faces_without_source = 0;  ///< target faces that no mapped source face lies near
  double factor_seconds = 0.0, frames_seconds = 0.0;
};

/// `map` has one target point per vertex of `source_rest`; `source` has the topology of
/// `source_rest`. Target faces far from every mapped source face turn as rigidly as
/// the border of their patch does in the mean.
/// Throws InputError when map, animation and meshes do not belong together, NoResultError when the
/// target cannot be factorised or nothing of it is mapped.
RetargetResult retarget(const AnimatedMesh& source, const Mesh& source_rest,
                        const Mesh& target_rest, const SurfaceMap& map, const RunContext& ctx = {});

}  // namespace kinemesh
