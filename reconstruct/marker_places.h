// Files that say where markers sit on a scan, as CSV with a header. One line per marker, by surface
// point (what Kinemesh writes), by vertex, or by a point near the skin in the scan's own unit:
//
//   label,face,b0,b1,b2      label,vertex      label,x,y,z
//
// Indices count from 0. An optional column `stand_off` (mm) is the marker's distance from the skin.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "reconstruct/drive_scan.h"

namespace kinemesh {

/// `scale` brings the file's x, y, z to millimetres; `stand_off_mm` holds where the file says none.
/// Throws InputError naming file and line for what is malformed or lies off the scan.
std::vector<AttachedMarker> read_marker_places(const std::filesystem::path& path, const Mesh& scan,
                                               double scale = 1.0, double stand_off_mm = 0.0);

/// The same places on a topology whose faces have the same vertices in another order, as when faces
/// were turned round.
std::vector<AttachedMarker> with_corners_of(std::vector<AttachedMarker> markers,
                                            const Topology& from, const Topology& to);

/// By surface point, every double exact.
std::string marker_places_csv(const std::vector<AttachedMarker>& markers);

}  // namespace kinemesh
