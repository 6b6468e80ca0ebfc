// Parts of a surface whose movement is summed up, and how far each moves over time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/comparison/comparison.h"
#include "analysis/comparison/movement_timing.h"

namespace kinemesh {

struct SurfaceRegion {
  std::string name;
  std::vector<VertexIndex> vertices;
};

/// The whole surface, then its upper, middle and lower third on the left and on the right, as the
/// surface faces (report/camera.h).
std::vector<SurfaceRegion> default_regions(const AnimatedMesh& mesh);

/// JSON: {"mouth": ["LMOU*", "CMOU01", 17], …}: vertices by number from 0 or by marker name with
/// wildcards. The whole surface comes first. Throws InputError naming region and entry.
std::vector<SurfaceRegion> read_regions(const std::filesystem::path& path,
                                        const AnimatedMesh& mesh);

/// A vertex by number, or all whose names match a wildcard; empty when there is none.
std::vector<VertexIndex> vertices_named(const std::string& name, const AnimatedMesh& mesh);

/// What one performance does in a region.
struct RegionCourse {
  /// How far it has moved towards its strongest pose, per frame of its own time: displacement along
  /// the displacement of that pose, root mean square over the region's area, mm.
  std::vector<double> amount_mm;
  std::optional<MovementTiming> timing;
  double largest_mm = 0.0;      ///< of amount_mm
  double largest_strain = 0.0;  ///< mean over the region of the largest stretch, at its largest, %
};

struct RegionResult {
  SurfaceRegion region;  ///< of A
  RegionCourse a, b;     ///< B at the corresponding places, each in its own time
  double shape_mean_mm = 0.0, shape_rms_mm = 0.0;
  double motion_rms_mm = 0.0, motion_largest_mm = 0.0;  ///< RMS over the region and all frames,
                                                        ///< and over the region at its largest
  double area_share = 0.0;
};

std::vector<RegionResult> compare_regions(const Comparison& c, const Topology& topology_b,
                                          std::vector<SurfaceRegion> regions, double rest_window_s);

/// Standard deviation of a curve over its first `seconds`, and its mean.
struct RestLevel {
  double mean = 0.0, noise = 0.0;
};
RestLevel rest_level(const std::vector<double>& curve, double rate_hz, double seconds);

}  // namespace kinemesh
