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
  std::size_t components = 0, isolated_vertices = 0;
  std::vector<std::string> notes;  ///< full sentences
};

/// Throws InputError for positions that are not finite and NoResultError for a scan without faces.
PreparedScan prepare_scan(const Mesh& scan);

struct ScanOpenings {
  std::size_t count = 0;  ///< boundary loops, the rim among them
  std::string note;       ///< of holes that are no rim, eyes or mouth; empty when there are none
};
/// A face scan is open at its rim, and may be at mouth and eyes: up to three loops of 40 mm and
/// more besides the longest. What is smaller, or more, is a hole. `scan` in mm.
ScanOpenings scan_openings(const Mesh& scan);

/// The factor that brings the scan to millimetres, judged by the extent of the markers (mm): 1 when
/// it fits as it is; that of metres, centimetres or inches. Throws NoResultError when no unit fits.
double scan_scale(const Mesh& scan, const std::vector<Eigen::Vector3d>& markers);

}  // namespace kinemesh
