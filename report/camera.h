// From where a scene is looked at: orthographic cameras with named views of a body.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "mesh/animated_mesh.h"
#include "mesh/topology.h"

namespace kinemesh {

/// Where a body faces and which way is up; unit vectors at right angles.
struct BodyAxes {
  Eigen::Vector3f front = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f up = Eigen::Vector3f::UnitY();
  bool faces = false;  ///< front is where an open surface faces, not just a body's broad side
};

/// left and right are the body's own; three_quarter looks from its front left, a little above.
enum class View { front, back, left, right, top, three_quarter };

/// Estimates how a mesh is oriented. Front is the mean outward normal where the surface is open
/// (a face); closed bodies are seen from their broad side. When `up` is not given it is the
/// coordinate axis that makes the mesh most symmetric left to right, in its positive direction
/// (for closed meshes: y). Degenerate meshes give the default axes.
BodyAxes estimate_axes(const Topology& topology, const FrameView& positions,
                       const std::optional<Eigen::Vector3f>& up = {});

/// Orthographic: `view_height` mm fill the height of the picture, whatever lies in front or behind.
struct Camera {
  Eigen::Matrix3f axes = Eigen::Matrix3f::Identity();  ///< rows: right, up, towards the viewer
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();    ///< mm; in the middle of the picture
  float view_height = 100.0F;                          ///< mm

  /// x to the right and y up from the picture's middle, z towards the viewer; mm.
  Eigen::Vector3f to_view(const Eigen::Vector3f& point) const { return axes * (point - centre); }
  /// Pixels from the top left corner of a picture of that size.
  Eigen::Vector2d project(const Eigen::Vector3f& point, double width, double height) const;
};

/// A camera of that view, not yet aimed (see aim).
Camera camera_for(View view, const BodyAxes& axes);
/// Moves and zooms the camera so that all finite points fit a picture of width / height = `aspect`,
/// with `margin` (a fraction of it) left on each side.
void aim(Camera& camera, std::span<const Eigen::Vector3f> points, double aspect,
         double margin = 0.06);

/// The rows of a frame as a list.
std::vector<Eigen::Vector3f> points_of(const FrameView& positions);

}  // namespace kinemesh
