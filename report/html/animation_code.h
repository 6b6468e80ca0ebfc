// An animated mesh made small enough for a web page: principal components and key frames, whole
// numbers instead of floats, and a statement of what that costs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "config/run_context.h"
#include "mesh/animated_mesh.h"

namespace kinemesh {

struct AnimationCodeOptions {
  std::size_t max_bytes = 1300000;  ///< of the code, before base64 (which adds a third)
  double max_error_mm = 0.05;       ///< enough: no more is stored once every sample is this near
  std::size_t max_modes = 200;      ///< more would play slowly in a browser
};

/// Frame f lies between the keys around f / key_step; its vertices are
/// mean + Σ_k scale[k] · score[key][k] · mode[k], scores interpolated linearly in time.
struct AnimationCode {
  std::string bytes;  ///< little-endian: mean f32[3V], modes i16[K][3V], scores i16[keys][K]
  std::vector<double> scales;  ///< one per mode
  std::size_t keys = 0;
  double key_step = 1.0;      ///< frames from key to key
  double max_error_mm = 0.0;  ///< largest distance of any decoded sample from the original
  double rms_error_mm = 0.0;
};

/// The least error within the budget; errors are measured by decoding every frame. Throws
/// NoResultError when not even the mean shape fits, or when there is no frame or vertex, and
/// InputError for positions that are not finite.
AnimationCode encode_animation(const AnimatedMesh& animation,
                               const AnimationCodeOptions& options = {},
                               const RunContext& ctx = {});

/// Decodes frame f, 3 × vertices in mm, as the page's script does.
std::vector<float> decode_frame(const AnimationCode& code, std::size_t vertex_count,
                                std::size_t frame);

}  // namespace kinemesh
