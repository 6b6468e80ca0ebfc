// A scan as it comes from a scanner, made fit to be driven; what was corrected is said.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/mesh.h"

namespace kinemesh {

struct PreparedScan {
  Mesh mesh;  ///< same vertices; faces oriented alike and outwards
  std::size_t turned_faces = 0;
  std::size_t components = 0, holes = 0, isolated_vertices = 0;
  std::vector<std::string> notes;  ///< full sentences
};

/// Throws InputError for positions that are not finite and NoResultError for a scan without faces.
PreparedScan prepare_scan(const Mesh& scan);

/// The factor that brings the scan to millimetres, judged by the extent of the markers (mm): 1 when
/// it fits as it is; that of metres, centimetres or inches. Throws NoResultError when no unit fits.
double scan_scale(const Mesh& scan, const std::vector<Eigen::Vector3d>& markers);

}  // namespace kinemesh
