// Which way a face looks: its mirror plane, its front, up, and the subject's left.
#pragma once

#include <optional>

#include "mesh/mirror_plane.h"
#include "reconstruct/edit_mesh.h"

namespace kinemesh {

struct FaceFrame {
  MirrorPlane plane;
  Eigen::Vector3d front = Eigen::Vector3d::UnitZ();  ///< mean outward normal, unit
  double spacing = 0.0;                              ///< h, mm

  /// The plane can be trusted to tell what lies in the middle and what on a side.
  bool symmetric() const { return plane.error < 0.2; }

  /// In the mirror plane, across the front, towards the forehead: where most of the face lies,
  /// seen from the mouth; without one, from the nose (the three markers near the plane that stand
  /// out most) to the eyes.
  Eigen::Vector3d up(const Points& points, const std::optional<Eigen::Vector3d>& mouth,
                     const Eigen::Vector3d& eyes) const;
};

/// `mesh` is oriented outwards.
FaceFrame find_face_frame(const EditMesh& mesh, const Points& points, double spacing);

}  // namespace kinemesh
