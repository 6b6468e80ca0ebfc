// What the Gaussian process learns a gap from: the donors' motion, the marker's own, and time.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "capture/fill/dense.h"
#include "capture/fill/spatial_guess.h"
#include "capture/fill/trajectories.h"
#include "capture/rigid_fit.h"

namespace kinemesh::fill {

struct TrainingOptions {
  std::size_t rows = 300;        ///< frames to learn from
  double near_s = 0.67;          ///< this much time on either side of the gap is taken densely
  double donor_range_mm = 40.0;  ///< donors count less with distance over this length, or over 1.2
                                 ///< × the mean distance to the five nearest, if that is larger
  std::size_t donors = 24;       ///< at most
  int frame_rounds = 2;          ///< refinements of the common frame's mean shape
  GuessOptions guess;
};

/// Frames, inputs and outputs; the columns of `inputs` are the rows, then the gap's frames.
struct TrainingSet {
  std::vector<std::size_t> rows;  ///< frames, ascending; the marker is measured in each
  std::vector<std::size_t> gap;   ///< the frames to estimate
  std::size_t donors = 0;         ///< 0: time is the only input
  /// (3 × donors) × (rows + gap): the donors' weighted displacements in the common frame, divided
  /// by their root mean square norm over the rows or, if that is larger, by the geometric mean of
  /// those over the rows and over the gap.
  Dense inputs;
  /// (rows + gap) × 3, mm: how the marker would move if it moved as what is around it. It is what
  /// holds where the donors do what they do in no row.
  Eigen::MatrixXd guess;
  Eigen::MatrixXd outputs;  ///< rows × 3, mm, in the common frame, without guess and mean
  Eigen::RowVector3d mean_output;
  std::vector<RigidFit> poses;  ///< of the gap's frames: common frame → recording
};

/// Donors are other markers that are measured throughout the gap and a few frames around it,
/// nearest first; when there are fewer than three of these, those that are measured in half of the
/// gap, completed by `rough`. Rows in which a donor is missing are left out; donors that would
/// cost too many rows are left out instead. Everything is expressed in a common frame that moves
/// with the donors (weighted rigid fit to their mean shape), so that head motion, however large, is
/// no part of what has to be learnt.
/// `rough`: the same take with every gap filled provisionally. `mirror`: where the two halves of
/// the face lie, or null.
TrainingSet make_training_set(const Trajectories& take, const Trajectories& rough,
                              const Mirror* mirror, const GapAt& gap,
                              const TrainingOptions& options);

}  // namespace kinemesh::fill
