// Surfaces that are no faces, for the triangulation of other marked objects: a sphere, a closed
// blob with limbs, the same cut open at the bottom, a bent tube with one closed end.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tests/support/geodesic_delaunay.h"
#include "tests/support/true_surface.h"

namespace kinemesh::test {

/// A sphere of 8 × divisions² triangles around the origin.
TrueSurface make_sphere(double radius_mm, int divisions = 36);

/// A closed surface of genus 0 with four to six limbs, about 500 mm across.
TrueSurface make_blob(uint64_t seed, int divisions = 40);

/// The same, cut off below: one boundary loop.
TrueSurface make_open_blob(uint64_t seed, int divisions = 40);

/// A tube bent by `bend_degrees`, closed by a dome at one end and open at the other.
TrueSurface make_bent_tube(double radius_mm, double length_mm, double bend_degrees);

/// Surface points at least `spacing_mm` from each other (straight), as many as fit; never at
/// vertices.
std::vector<SurfacePoint> scatter_markers(const TrueSurface& surface, double spacing_mm,
                                          uint64_t seed);
/// Their positions in mm.
std::vector<Eigen::Vector3d> positions_of(const TrueSurface& surface,
                                          std::span<const SurfacePoint> points);

}  // namespace kinemesh::test
