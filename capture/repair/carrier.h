// Carries labels from one frame to the others. Internal to labelling.
#pragma once

#include <vector>

#include "capture/repair/local_motion.h"

namespace kinemesh::repair {

/// The points of one frame; label −1: none yet.
struct LoosePoints {
  std::vector<Eigen::Vector3d> positions;
  std::vector<int> labels;
};

/// Labels run both ways from a frame in which they are known. Labels that are fixed already (in
/// `motion`) lead where they are.
class LabelCarrier {
 public:
  /// `start` positions of all labels in frame `frame`, estimated where they are not seen.
  LabelCarrier(std::vector<LoosePoints>& points, LocalMotion& motion,
               std::vector<Eigen::Vector3d> start, std::size_t frame);
  void run();

 private:
  struct Link {
    double cost;
    std::size_t label, point;
  };
  struct State {
    std::vector<Eigen::Vector3d> last;
    std::vector<std::size_t> seen;  ///< frame of `last`
  };
  void step(State& state, std::size_t from, std::size_t to);
  void assign(std::vector<Link>& links, std::size_t frame);
  /// Points of the frame within `reach` of `place` that have no label.
  void offer(std::size_t label, const Eigen::Vector3d& place, double reach, std::size_t frame,
             std::vector<Link>& links) const;
  Eigen::Vector3d ahead(const State& state, std::size_t label, std::size_t from,
                        std::size_t to) const;

  std::vector<LoosePoints>& points_;
  LocalMotion& motion_;
  std::vector<Eigen::Vector3d> start_;
  std::size_t frame_;
};

}  // namespace kinemesh::repair
