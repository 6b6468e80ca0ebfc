// A topology carried through all frames of a take, and how well it holds in each.
#pragma once

#include <memory>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"

namespace kinemesh {

struct CarryOptions {
  double degenerate_height =
      0.05;  ///< a triangle is degenerate below this height over longest edge

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// Quality of the mesh in one frame.
struct FrameQuality {
  uint32_t flipped = 0;     ///< triangles turned against the surface around them
  uint32_t degenerate = 0;  ///< triangles (almost) without area that have some in the reference
  float stretch_min = 1;    ///< shortest edge over its length in the reference frame
  float stretch_max = 1;    ///< longest edge over its length in the reference frame
  float stretch_rms = 0;    ///< root of the mean of (length ratio − 1)²
  uint32_t filled = 0;      ///< samples that are estimated rather than measured
};

struct CarrySummary {
  std::size_t frames_with_flips = 0;
  std::size_t worst_frame = 0;  ///< 0-based frame with most flipped and degenerate triangles
  uint32_t worst_count = 0;     ///< how many it has
  float stretch_min = 1, stretch_max = 1;
  std::size_t filled_samples = 0;
  std::size_t samples = 0;
  /// Vertices that are corners of flipped triangles most often, at least half as often as the
  /// first of them, at most four.
  std::vector<VertexIndex> flip_suspects;
};

struct CarryResult {
  AnimatedMesh animation;
  std::vector<FrameQuality> quality;  ///< one per frame
  CarrySummary summary;
};

/// The markers of `take` as vertices of `topology` (vertex i is marker i), in every frame; names,
/// filled flags, uncertainty, events, rate and first frame number come along. `reference` is the
/// 0-based frame that lengths and orientations are compared with.
/// Throws InputError naming marker and frame for a sample that is invalid or not finite, or when
/// vertex and marker counts differ.
CarryResult carry_topology(std::shared_ptr<const Topology> topology, const MarkerSequence& take,
                           std::size_t reference, const CarryOptions& options = {},
                           const RunContext& ctx = {});

/// The quality of one frame of positions (vertices × 3, mm) against reference positions: the
/// streaming form of the record above.
FrameQuality frame_quality(const Topology& topology, FrameView reference, FrameView frame,
                           const CarryOptions& options = {});

}  // namespace kinemesh
