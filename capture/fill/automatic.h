// The default way of filling a gap.
#pragma once

#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// Prepared once for a take, then asked for each gap, from any thread.
class Automatic {
 public:
  explicit Automatic(const Trajectories& take) : take_(take) {}
  /// Always gives an estimate, with its uncertainty, for a marker that is measured at least once.
  Estimate fill(const GapAt& gap) const;

 private:
  const Trajectories& take_;
};

}  // namespace kinemesh::fill
