// What a camera system makes of true marker positions: noise, gaps, a label swap; and how a head
// wanders while it is recorded.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "tests/support/random.h"

namespace kinemesh::test {

struct TakeOptions {
  double rate_hz = 120;
  double duration_s = 3.5;
  double noise_mm = 0.15;      ///< standard deviation on each coordinate
  std::size_t short_gaps = 0;  ///< of 0.02 to 0.15 s, mostly of two to four neighbours at once
  std::size_t long_gaps = 0;   ///< of 0.3 to 1 s, one marker each, head rig included
  double head_degrees = 0;     ///< amplitude of head rotation about each axis
  double head_mm = 0;          ///< amplitude of head translation along each axis
  bool head_rig = false;       ///< adds six rigid markers after those of the face
  bool label_swap = false;     ///< two neighbouring markers exchange names from some frame on
  std::string subject = "subject";
  uint64_t seed = 1;
};

struct GapRecord {
  std::size_t marker, first_frame, last_frame;  ///< 0-based, inclusive
};
struct SwapRecord {
  std::size_t first, second;  ///< markers whose trajectories are exchanged
  std::size_t from_frame;     ///< from here to the end of the take
};

struct Recording {
  MarkerSequence measured, truth;
  std::vector<GapRecord> gaps;
  std::optional<SwapRecord> swap;
};

/// True positions of all markers in one frame, mm.
using TrueMarkers = std::function<std::vector<Eigen::Vector3d>(std::size_t frame)>;

/// Records the markers in every frame. The first `face_markers` are those of the face: short gaps
/// and the label swap concern them alone. `random` gives the seeds of noise, gaps and swap.
Recording record(const std::vector<Marker>& markers, std::size_t face_markers,
                 const TrueMarkers& true_markers, const TakeOptions& options, Random& random);

/// A wandering head: per frame, the pose that takes coordinates of the head's frame (y up, z
/// forward) to the lab's (z up, y backwards).
std::vector<Eigen::Isometry3d> wandering_head(std::size_t frames, const TakeOptions& options,
                                              Random random);

}  // namespace kinemesh::test
