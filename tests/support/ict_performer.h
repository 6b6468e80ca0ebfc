// A performer with truth: any subject of the linear face model doing any motion, as an animated
// mesh on the model's connectivity or on an independent one, and as recorded markers.
//
// The model gives every subject the same displacement vectors, which leaks the answer to whoever
// compares subjects by displacement: `IctVariation` turns, scales and delays them per subject.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mesh/animated_mesh.h"
#include "mesh/surface_point.h"
#include "tests/support/ict_model.h"
#include "tests/support/recording.h"

namespace kinemesh::test {

/// A person: standard normal identity weights drawn from the seed; seed 0 is the neutral face.
struct IctSubject {
  uint64_t seed = 1;
  double spread = 1;  ///< standard deviation of the weights
};

/// One expression of the model, rising from onset to peak, held to release, gone at the end.
struct IctPulse {
  std::size_t expression = 0;
  double strength = 1;
  double onset_s = 0, peak_s = 0, release_s = 0, end_s = 0;
};
struct IctMotion {
  std::vector<IctPulse> pulses;
  double duration_s = 2;
};
/// Five groups of expressions mixed in time, drawn from the seed: each in another region of the
/// face or another way to move it, mostly on both sides.
IctMotion make_ict_motion(const IctModel& model, uint64_t seed, double duration_s = 2);

/// How far a subject's own way of moving differs; the amounts are drawn from the subject's seed.
struct IctVariation {
  double turn_degrees = 0;  ///< displacement vectors are turned by up to this, all alike
  double scale = 0;         ///< each expression's strength is multiplied by 1 ± up to this
  double delay_s = 0;       ///< the whole motion starts later by up to this
};

struct PerformOptions {
  double rate_hz = 60;
  IctVariation variation;
  std::size_t remesh_vertices = 0;       ///< 0: the model's own connectivity
  double noise_mm = 0;                   ///< on each coordinate of each vertex and frame
  double head_degrees = 0, head_mm = 0;  ///< rigid head motion, as in TakeOptions
  uint64_t seed = 1;                     ///< of noise and head motion
};

struct Performance {
  AnimatedMesh mesh;
  /// Where each vertex of the mesh lies on the model: face and weights of its topology.
  std::vector<SurfacePoint> on_model;
  /// Per frame: face frame → frame of the mesh; identity when the head does not move.
  std::vector<Eigen::Isometry3d> head_pose;
};

/// The face at one instant: neutral + identity + varied expressions, per vertex of the model, mm.
class IctActor {
 public:
  /// Keeps a reference to the model.
  IctActor(const IctModel& model, const IctSubject& subject, const IctMotion& motion,
           const IctVariation& variation = {});
  const IctModel& model() const { return model_; }
  /// Without expression.
  const std::vector<Eigen::Vector3d>& rest() const { return rest_; }
  std::vector<Eigen::Vector3d> at(double time_s) const;
  /// Strength of each pulse of the motion at that time, as the subject does it.
  std::vector<double> strengths(double time_s) const;
  double duration_s() const { return motion_.duration_s; }
  double delay_s() const { return delay_; }

 private:
  const IctModel& model_;
  IctMotion motion_;
  std::vector<Eigen::Vector3d> rest_;
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();
  double delay_ = 0;
};

Performance perform(const IctActor& actor, const PerformOptions& options = {});
Performance perform(const IctModel& model, const IctSubject& subject, const IctMotion& motion,
                    const PerformOptions& options = {});

/// The truth between two performances: for each vertex of `source` the point of `target`'s mesh
/// that is the same place of the model.
SurfaceMap true_map(const IctModel& model, const Performance& source, const Performance& target);

/// Points of the face (no ears, neck and scalp) at least `least_mm` from each other on the neutral
/// face, at least 3 mm from the edges of lips and lids, never at vertices. 9 mm gives about 160.
std::vector<SurfacePoint> place_ict_markers(const IctModel& model, double least_mm, uint64_t seed);

struct IctTake {
  MarkerSequence measured, truth;
  std::vector<SurfacePoint> points;  ///< on the model
  std::vector<Eigen::Isometry3d> head_pose;
  std::vector<GapRecord> gaps;
  std::optional<SwapRecord> swap;
};
/// Markers "M001", … on the actor's face, recorded. `options.duration_s` is ignored: the motion's
/// is taken; a head rig is not added.
IctTake record_ict(const IctActor& actor, const std::vector<SurfacePoint>& points,
                   const TakeOptions& options = {});

}  // namespace kinemesh::test
