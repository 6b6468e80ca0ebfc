// What is compared at a place of two surfaces: strain over time, normals, and how far the mouth,
// the eyes and the rim are. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "analysis/spherical/closed_surface.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"

namespace kinemesh::full_matching {

/// Channels 0–2: unit normal; 3, 4: nearness of the longest loop and of the nearest other one;
/// 5–7: direction along the nearest loop, times its nearness (which tells upper lip from lower,
/// corners, and where along the rim); 8–15: strain of the whole motion in the principal components
/// of both surfaces.
inline constexpr int channels = 16, first_loop = 3, first_tangent = 5, first_strain = 8;
using Signal = Eigen::Matrix<float, channels, 1>;

/// Standard deviations of the blurred signals, √area.
inline constexpr std::array<double, 3> blurs{0.04, 0.02, 0.01};

struct SurfaceSignals {
  std::vector<Eigen::Vector3d> positions;  ///< of the closed surface at rest, its area being 1
  std::vector<Signal> values;              ///< per vertex of the closed surface
  /// The same blurred by `blurs[k]`: coarse meshes must not see what is finer than their edges.
  std::array<std::vector<Signal>, 3> blurred;
  const std::vector<Signal>& seen_by(double edge) const;
  std::vector<double> areas;  ///< per vertex, of the open surface; 0 in fillings
  double root_area_mm = 0.0;
};

struct SignalPair {
  SurfaceSignals a, b;
  bool has_strain = false, has_loops = false;
};

/// The rest pose is the first frame. Strain is resampled to `instants` of either motion's
/// duration and scaled to the same mean square on both, so that amplitude does not matter.
SignalPair compare_signals(const AnimatedMesh& a, const ClosedSurface& closed_a,
                           const AnimatedMesh& b, const ClosedSurface& closed_b, int instants,
                           const RunContext& ctx);

}  // namespace kinemesh::full_matching
