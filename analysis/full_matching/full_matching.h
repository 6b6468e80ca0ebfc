// A one-to-one map between two moving surfaces, vertex by vertex.
//
//   const FullMatching m = match_surfaces(anna, ben);
//   m.forward.points[v]: where vertex v of anna lies on ben;  m.reverse: ben → anna
//
// Holes are closed (closed_surface.h), both surfaces are mapped to the sphere (spherical_map.h,
// Mykhalchuk 2015, 5.6), and A is laid over B by a rotation that is chosen among many by what the
// places then have in common. A is then collapsed to a few hundred vertices, which move over B to
// lower distortion + differences of strain over time, normals and nearness of the boundary loops;
// its other vertices come back level by level and move likewise. No triangle is turned over at any
// step. How much each signal counts is measured on the pair: by how much less it differs than
// between places taken at random.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "analysis/full_matching/surface_overlay.h"
#include "analysis/spherical/spherical_map.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/landmarks.h"
#include "mesh/surface_point.h"

namespace kinemesh {

struct FullMatchingOptions {
  double keep_shape = 0.6;  ///< weight of the distortion
  double strain_weight = 0.5;
  double normal_weight = 1.0;
  double loop_weight = 20.0;
  double smooth_weight = 120.0;  ///< of a smooth deformation of space
  int strain_instants = 24;      ///< at which the motions are compared
  double snap = 0.01;            ///< √area of the target
  int rotations = 1000;          ///< tried for the start
  SphericalOptions sphere;
  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// A signal's part in a map: 1 − its mean squared difference over that of places taken at random.
/// Below about 0.1 the map says nothing about it; 0 when the surfaces do not have it.
struct SignalAgreement {
  double strain = 0.0, normals = 0.0, loops = 0.0;
};

struct FullMatching {
  /// Samples of the overlay at the vertices; what falls near the edge of a hole lies on it.
  SurfaceMap forward, reverse;
  /// Carries any point, in either direction; as matched, without what is moved to edges of holes.
  std::shared_ptr<const SurfaceOverlay> overlay;
  ThereAndBack exactly, by_vertices;  ///< of the overlay, and of the samples
  /// Per source vertex: symmetric Dirichlet energy / 4 of the map around it; 1 where isometric.
  std::vector<double> distortion;
  double mean_distortion = 0.0;  ///< over the source's area
  SignalAgreement agreement;     ///< of the final map
  double sphere_distortion_source = 0.0, sphere_distortion_target = 0.0;
  SphereCheck check;  ///< of the source's triangles on the target's sphere: no fold; always valid
  std::size_t unmapped_source = 0, unmapped_target = 0;  ///< in a hole of the other surface
  std::size_t snapped_source = 0, snapped_target = 0;    ///< moved to the loop of such a hole
  bool poor = false;
  std::string warning;  ///< why the map is poor and what to do; empty otherwise
};

/// The map leads each landmark, a vertex of the source, exactly to its point of the target. Throws
/// NoResultError for surfaces that cannot be mapped to the sphere, when a map would fold, and
/// naming landmarks that cannot be met; InputError for positions that are not finite or an
/// animation without frames.
FullMatching match_surfaces(const AnimatedMesh& source, const AnimatedMesh& target,
                            const FullMatchingOptions& options = {}, const RunContext& ctx = {},
                            std::span<const LandmarkPair> landmarks = {});

}  // namespace kinemesh
