// How a marker would move if it moved as what is around it, and as the other half of the face does.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "capture/fill/common_frame.h"
#include "capture/fill/mirror.h"
#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// Whether the law of the covariance is the usual one, or what fits the gap.
enum class GuessAdapt {
  never,
  where_new,  ///< where one of the donors goes a fifth farther in the gap than in any row
  always,
};

struct GuessOptions {
  std::size_t donors = 8;  ///< the nearest ones, on either half
  double range = 2.0;      ///< of their covariance, in their mean distances
  double nugget = 0.25;    ///< what tells each from its surroundings, noise among it
  GuessAdapt adapt = GuessAdapt::always;
};

/// Where a guess is made: the marker's gap, its donors (nearest first), and their common frame over
/// `rows` rows and then the frames of the gap.
struct GuessPlace {
  const Trajectories& take;
  const Trajectories& rough;
  const GapAt& gap;
  const std::vector<std::size_t>& donors;
  const std::vector<std::size_t>& frames;
  std::size_t rows = 0;
  const CommonFrame& frame;
  Eigen::Vector3d own = Eigen::Vector3d::Zero();  ///< the marker's mean place in the common frame
};

/// (rows + gap) × 3, mm, in the common frame: ordinary kriging (Matheron 1963) of the displacements
/// from the mean over the rows, with a Matérn 3/2 covariance over the distance. With `mirror`, the
/// markers nearest to the marker's mirror image take part, too: their displacements (relative to
/// their own surroundings' common frame), reflected, are those of a second field that goes with the
/// first. How closely, how far motion reaches and how much each place has of its own is what lets
/// the donors be guessed best from each other in the gap (leave-one-out cross-validation). Zero
/// where fewer than three donors are known.
Eigen::MatrixXd spatial_guess(const GuessPlace& place, const Mirror* mirror,
                              const GuessOptions& options);

}  // namespace kinemesh::fill
