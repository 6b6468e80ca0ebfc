// The true surface that generated markers lie on, with the openings it may have.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mesh/surface_point.h"
#include "mesh/topology.h"

namespace kinemesh::test {

/// A cut in the surface whose two sides may part: lips, lids. Vertex k of `upper` lies opposite
/// vertex k of `lower`; the first and the last are common to both (the corners).
struct Slit {
  std::string name;  ///< "mouth", "left_eye", "right_eye"
  std::vector<VertexIndex> upper, lower;
};

struct TrueSurface {
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> positions;  ///< one per vertex, mm
  std::vector<Eigen::Vector2d> domain;     ///< planar coordinates per vertex; empty for bodies
  std::vector<Slit> slits;
};

/// The surface with every slit that is not named in `open` closed for good: its sides are sewn
/// together where they touch and bridged by triangles where they do not. Faces keep their
/// indices (bridges come last), so surface points stay valid.
TrueSurface close_slits(const TrueSurface& surface, const std::vector<std::string>& open);

}  // namespace kinemesh::test
