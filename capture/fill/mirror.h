// Where the two halves of a marker set lie that mirror each other.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "capture/fill/trajectories.h"
#include "mesh/mirror_plane.h"

namespace kinemesh::fill {

struct Mirror {
  std::vector<Eigen::Vector3d> shape;  ///< one place a marker, mm: the mean over some frames
                                       ///< without head motion, in the first one's coordinates
  std::vector<std::size_t> known;      ///< markers that have a place
  MirrorPlane plane;                   ///< in the same coordinates
};

/// `rough`: every gap filled provisionally. Nothing for fewer than eight markers, or when they lie
/// about no plane like mirror images.
std::optional<Mirror> find_mirror(const Trajectories& rough);

}  // namespace kinemesh::fill
