// Dynamic features of an animated mesh: places and moments at which its surface deforms or moves
// in a way that can be found again on another mesh (Mykhalchuk 2015, chapters 4 and 5.3–5.4).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh {

enum class FeatureKind : uint8_t {
  deformation,  ///< an extremum of the spatio-temporal DoG of deformation (thesis 4.8)
  displacement  ///< a local maximum of the length of the vertices' paths (thesis 5.4)
};

/// What a feature looks like to those who match it (thesis 5.3). A part that was not computed is
/// empty.
struct FeatureDescriptor {
  /// Length of the step from each frame to the next over the largest of the animation, frames − 1
  /// values in [0, 1] (5.3.1).
  std::vector<float> displacement;
  /// Deformation at the vertex over the largest of the animation, one value per frame (5.3.3).
  std::vector<float> deformation;
  /// AnimMeshHoG (5.3.4): 8 octants × 4 elevations × 8 azimuths, azimuth fastest; sum 1 over all.
  /// Octant o lies on the positive side of x, y, t where bits 0, 1, 2 of o are set.
  std::vector<float> histogram;
};

struct Feature {
  VertexIndex vertex = 0;  ///< 0-based
  uint32_t frame = 0;      ///< 0-based
  double time_s = 0.0;     ///< since the first frame; 0 when the rate is unknown
  double sigma_mm = 0.0;   ///< spatial scale: standard deviation of the Gaussian; 0: none
  double tau_s = 0.0;      ///< temporal scale, likewise; in frames when the rate is unknown
  double response = 0.0;   ///< strength, larger is stronger; comparable within one kind and run
  FeatureKind kind = FeatureKind::deformation;
  FeatureDescriptor descriptor{};
};

/// The features of one animation, and what is needed to compare them with those of another.
struct FeatureSet {
  std::string animation;         ///< the file or take it was found in
  std::size_t vertex_count = 0;  ///< of the animation
  std::size_t frame_count = 0;   ///< of the animation
  double rate_hz = 0.0;          ///< 0: unknown
  double diagonal_mm = 0.0;      ///< of the bounding box of the rest shape
  /// Those of one kind together, the strongest first.
  std::vector<Feature> features;
};

/// "deformation", "displacement".
const char* name_of(FeatureKind kind);

}  // namespace kinemesh
