// The linear face model in KINEMESH_DATA/face_ict (ICT-FaceKit, MIT): identity and expression add
// displacements to a neutral face. All in mm here; x to the subject's left, y up, z forward.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh::test {

struct IctModel {
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> neutral;                   ///< per vertex, mm
  std::vector<std::vector<Eigen::Vector3f>> identities;   ///< 50 × vertices, mm at weight 1
  std::vector<std::vector<Eigen::Vector3f>> expressions;  ///< 57 × vertices, mm at weight 1
  std::vector<std::string> expression_names;
  std::vector<VertexIndex>
      landmarks;                   ///< 68, in the usual order: jaw line, brows, nose, eyes, mouth
  std::vector<VertexIndex> rigid;  ///< as in meta.json; some of them move with the jaw

  /// Index of an expression ("jawOpen"). Throws UsageError naming the nearest one.
  std::size_t expression(std::string_view name) const;
};

/// Reads a folder with neutral.ply, identity_deltas.f32, expression_deltas.f32 and meta.json.
/// Throws InputError naming the file when one is missing or has the wrong size.
std::shared_ptr<const IctModel> load_ict(const std::filesystem::path& folder);
/// That of data_folder(), read once.
const IctModel& ict_model();

}  // namespace kinemesh::test
