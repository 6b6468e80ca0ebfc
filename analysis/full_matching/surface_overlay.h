// Two surfaces laid over one sphere: any point of one is carried to the other and back.
//
// Both are triangulations of the sphere, and a point goes along the ray from the sphere's centre
// through its place in the one's triangle to where that ray meets a triangle of the other. The way
// back follows the same ray: each direction is the inverse of the other, within triangles too. The
// maps of vertices (SurfaceMap) are samples of it; read as linear over triangles, they are inverses
// only as far as the triangles are fine.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/spherical/closed_surface.h"
#include "analysis/spherical/sphere_locator.h"
#include "mesh/surface_point.h"

namespace kinemesh {

class SurfaceOverlay {
 public:
  /// Both spheres must be valid (check_sphere).
  SurfaceOverlay(ClosedSurface source, std::vector<Eigen::Vector3d> source_sphere,
                 ClosedSurface target, std::vector<Eigen::Vector3d> target_sphere);
  SurfaceOverlay(const SurfaceOverlay&) = delete;
  SurfaceOverlay& operator=(const SurfaceOverlay&) = delete;

  /// The point of the other surface; invalid where that has a hole, and for invalid points.
  SurfacePoint to_target(const SurfacePoint& of_source) const;
  SurfacePoint to_source(const SurfacePoint& of_target) const;
  /// The same of the closed surfaces: faces of fillings follow those of the surface.
  SurfacePoint to_closed_target(const SurfacePoint& of_source) const;
  SurfacePoint to_closed_source(const SurfacePoint& of_target) const;

  const ClosedSurface& source() const { return source_.surface; }
  const ClosedSurface& target() const { return target_.surface; }

 private:
  struct Side {
    Side(ClosedSurface closed, std::vector<Eigen::Vector3d> points)
        : surface(std::move(closed)),
          sphere(std::move(points)),
          locator(*surface.topology, sphere) {}
    ClosedSurface surface;
    std::vector<Eigen::Vector3d> sphere;
    SphereLocator locator;
  };
  Side source_, target_;
};

/// How far points are from themselves after the way to the other surface and back, over √area of
/// their surface, straight.
struct ThereAndBack {
  double mean = 0.0, worst = 0.0;
  std::size_t points = 0;  ///< that have a place on both surfaces
};
/// Of the source's vertices and the middles of its faces, carried by the overlay, and of the
/// target's; the worse of the two.
ThereAndBack there_and_back(const SurfaceOverlay& overlay);
/// Of the source's vertices by the maps alone, `reverse` being linear over the target's triangles.
ThereAndBack there_and_back(const SurfaceMap& forward, const SurfaceMap& reverse,
                            const ClosedSurface& source, const ClosedSurface& target);

}  // namespace kinemesh
