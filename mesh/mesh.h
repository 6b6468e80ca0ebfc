// A static triangle mesh: one topology and one set of positions, in millimetres.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

struct Mesh {
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3f> positions;  ///< one per vertex, mm
  std::vector<std::string> vertex_names;   ///< empty, or one per vertex
};

/// A sequence in which every frame has its own connectivity.
struct MeshSequence {
  std::vector<Mesh> frames;
  double rate_hz = 0.0;  ///< 0 when the source does not say
};

}  // namespace kinemesh
