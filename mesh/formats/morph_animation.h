// An animation as glTF can play it: a base shape, morph targets from a PCA of the motion, and their
// weights at keys between which the viewer interpolates linearly.
//
// The weights are the least-squares linear spline of the scores, so that a lower key rate costs as
// little as it can. The root mean square error of every choice of modes and key rate follows from
// the spectrum and the splines alone; the error that is reported is measured on the values as
// stored, vertex by vertex and frame by frame.
#pragma once

#include <cstddef>
#include <vector>

#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/formats/options.h"

namespace kinemesh {

struct MorphAnimation {
  std::size_t vertex_count = 0, target_count = 0;
  std::vector<float> base;        ///< vertices × 3, metres, axes as in the mesh; all weights 0
  std::vector<float> targets;     ///< targets × vertices × 3, metres
  std::vector<std::size_t> keys;  ///< frame of each key, ascending; first and last frame included
  std::vector<float> weights;     ///< keys × targets, within [0, 1]
  double max_error_mm = 0.0;      ///< measured over all vertices and frames
  double rms_error_mm = 0.0;
};

/// Bytes that a file takes beside its modes: used to keep to the budget.
struct MorphCost {
  std::size_t fixed = 0;       ///< mesh, JSON, headers
  std::size_t per_target = 0;  ///< JSON of one target; its 12 bytes a vertex are counted apart
};

/// Throws NoResultError when the budget does not hold even the still mesh, or the error asked for
/// cannot be reached in single precision.
MorphAnimation morph_animation_of(const AnimatedMesh& mesh, const GltfOptions& options,
                                  const MorphCost& cost, const RunContext& ctx);

/// Values at `keys` of the linear spline that is closest to `values` (one per frame) in the least
/// squares sense. `keys` ascend from 0 to values.size() − 1.
std::vector<double> fit_linear_spline(const std::vector<double>& values,
                                      const std::vector<std::size_t>& keys);

/// Every `step`-th frame, and the last one.
std::vector<std::size_t> key_frames(std::size_t frame_count, std::size_t step);

}  // namespace kinemesh
