// The default way of filling a gap: a Gaussian process on the other markers and time.
#pragma once

#include <optional>
#include <vector>

#include "capture/fill/gaussian_process.h"
#include "capture/fill/mirror.h"
#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// How much a gap may cost.
struct AutomaticOptions {
  bool fast = false;  ///< fewer rows, donors and settings: a tenth of the time
};

/// Prepared once for a take, then asked for each gap, from any thread.
class Automatic {
 public:
  explicit Automatic(const Trajectories& take, const AutomaticOptions& options = {});
  /// Always gives an estimate, with its uncertainty, for a marker that is measured at least once.
  Estimate fill(const GapAt& gap) const;
  const Trajectories& rough() const { return rough_; }  ///< fill_roughly() of the take

 private:
  const Trajectories& take_;
  AutomaticOptions options_;
  Trajectories rough_;
  std::optional<Mirror> mirror_;
  std::vector<double> noise_;  ///< variance by marker, mm²; of those with gaps
};

/// The take with every gap filled provisionally: by the mean displacement of up to six neighbours
/// seen throughout it, or on a straight line, joined to the measured samples at both ends.
Trajectories fill_roughly(const Trajectories& take);

}  // namespace kinemesh::fill
