// Landmarks given by hand, as vertices of A and points of B's sphere. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "analysis/full_matching/landmark_warp.h"
#include "analysis/spherical/closed_surface.h"
#include "mesh/landmarks.h"

namespace kinemesh::full_matching {

/// Throws InputError for a landmark inside a face of A or of faces that do not exist, NoResultError
/// naming two landmarks that no one-to-one map can meet.
std::vector<Anchor> anchors_of(std::span<const LandmarkPair> landmarks, const ClosedSurface& a,
                               const ClosedSurface& b, std::span<const Eigen::Vector3d> sphere_b);

/// Throws NoResultError that names the landmarks `away`, by index.
[[noreturn]] void refuse_landmarks(std::span<const LandmarkPair> landmarks,
                                   std::span<const std::size_t> away);

}  // namespace kinemesh::full_matching
