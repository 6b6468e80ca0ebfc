// What there is to know about a mesh at a glance: size, timing, extent, topology, worst triangles.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/mesh.h"

namespace kinemesh {

/// A triangle in the frame in which it is worst.
struct WorstTriangle {
  FaceIndex face = invalid_index;  ///< 0-based
  std::size_t frame = 0;           ///< 0-based frame of the mesh
  double smallest_angle_deg = 0;   ///< 60 at best
  double aspect = 0;  ///< circumradius / (2 × inradius): 1 at best, infinite when flat
};

struct MeshInfo {
  std::size_t vertices = 0, faces = 0, edges = 0, frames = 0;
  double rate_hz = 0, duration_s = 0;  ///< 0 when not known
  int64_t first_frame = 1;
  Eigen::Vector3f low, high;  ///< bounding box over all frames, mm
  std::size_t components = 0, isolated_vertices = 0;
  std::vector<std::size_t> boundaries;  ///< vertices of each loop, longest first
  int64_t euler_characteristic = 0;
  bool manifold = false;
  std::optional<int64_t> genus;      ///< of all components together; empty when not manifold
  std::vector<WorstTriangle> worst;  ///< by smallest angle, ascending
  double mean_edge_mm = 0;           ///< of the first frame
  std::size_t filled_samples = 0, samples = 0;
  std::size_t named_vertices = 0, events = 0;
};

/// `worst_count` triangles are listed, each in its worst frame.
MeshInfo mesh_info_of(const AnimatedMesh& mesh, std::size_t worst_count = 5,
                      const RunContext& ctx = {});

/// Smallest angle in degrees and aspect of one triangle; 0 and infinity when two corners coincide.
struct TriangleShape {
  double smallest_angle_deg = 0;
  double aspect = 0;
};
TriangleShape shape_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                       const Eigen::Vector3d& c);

}  // namespace kinemesh
