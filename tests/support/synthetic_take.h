// A recorded take of a synthetic face with everything known: noise-free markers, the surface and
// the head pose of every frame, gaps, a label swap, which openings open and when.
//
// Lab frame: x to the subject's left, y backwards, z up, mm (the face frame turned upright and
// placed at head height).
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "tests/support/geodesic_delaunay.h"
#include "tests/support/marker_layout.h"
#include "tests/support/recording.h"
#include "tests/support/synthetic_face.h"

namespace kinemesh::test {

/// One rise and fall of an elementary expression: smooth from `onset_s` to `peak_s`, held until
/// `release_s`, gone at `end_s`.
struct ExpressionPulse {
  Expression expression = Expression::jaw_open;
  double strength = 1;
  double onset_s = 0, peak_s = 0, release_s = 0, end_s = 0;
};

/// What the subject does in a take.
struct Motion {
  std::string name;
  std::vector<ExpressionPulse> pulses;
  /// Names of the slits that open or shut so much that the mesh should have an opening there.
  std::vector<std::string> openings;
  double onset_s = 0, peak_s = 0;  ///< of the main expression

  ExpressionWeights at(double time_s) const;
};

/// Motions of about 3.5 s. Openings in brackets.
enum class MotionKind : uint8_t {
  happy,       ///< smile, lips part, one blink (mouth, eyes)
  surprise,    ///< brows up, jaw drops, one blink (mouth, eyes)
  jaw,         ///< the jaw opens and shuts, nothing else (mouth)
  brows,       ///< brows up, then a frown (nothing)
  blinks,      ///< two blinks (eyes)
  pucker,      ///< puckered lips that stay shut (nothing)
  pucker_jaw,  ///< puckered lips, then the jaw opens (mouth)
  talk,        ///< several small openings of jaw and lips, one blink (mouth, eyes)
  puff,        ///< puffed cheeks, nose wrinkled, closed smile (nothing)
};
Motion make_motion(MotionKind kind);
/// The same motion as another person, or the same one another day, does it: earlier or later by
/// up to 0.15 s, up to 8 % faster or slower, each part up to 10 % weaker or stronger.
Motion vary(const Motion& motion, uint64_t seed);

struct SyntheticTake {
  std::shared_ptr<const SyntheticFace> face;
  MarkerLayout layout;
  Motion motion;
  MarkerSequence measured;  ///< markers 0 … layout.size() − 1 are the layout's, then the head rig
  MarkerSequence truth;     ///< the same markers: no noise, no gap, no swap
  std::vector<Eigen::Isometry3d> head_pose;  ///< per frame, face frame → lab frame
  std::vector<ExpressionWeights> weights;    ///< per frame
  std::vector<GapRecord> gaps;
  std::optional<SwapRecord> swap;

  std::size_t face_marker_count() const { return layout.size(); }
  /// The true surface of a frame in the lab frame.
  TrueSurface surface_at(std::size_t frame) const;
  /// The geodesic Delaunay triangulation of the face's markers in a frame, with the openings
  /// that the motion opens.
  GeodesicDelaunay reference_at(std::size_t frame) const;
};

SyntheticTake make_take(std::shared_ptr<const SyntheticFace> face, const MarkerLayout& layout,
                        const Motion& motion, const TakeOptions& options = {});

/// Names of the head rig's markers, as labs give them.
const std::vector<std::string>& head_rig_labels();

}  // namespace kinemesh::test
