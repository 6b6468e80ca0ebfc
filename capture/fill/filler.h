// Fills one gap at a time by the method that the options name: what fill_gaps() and its evaluation
// share.
#pragma once

#include "capture/fill/automatic.h"
#include "capture/gap_fill.h"

namespace kinemesh::fill {

struct Filled {
  std::optional<Estimate> estimate;  ///< nothing: left open
  FillMethod method = FillMethod::automatic;
};

class Filler {
 public:
  /// Resolves labels against the take's markers. Throws UsageError for a label that does not exist.
  /// `trajectories` must outlive this object.
  Filler(const std::vector<Marker>& markers, const Trajectories& trajectories,
         const GapFillOptions& options);
  /// With an uncertainty for every sample.
  Filled fill(const GapAt& gap) const;
  /// The same positions; methods that know no uncertainty of their own leave it empty.
  std::optional<Estimate> estimate(const GapAt& gap) const;

 private:
  std::optional<Estimate> by_method(const GapAt& gap) const;

  const Trajectories& take_;
  FillMethod method_;
  bool fill_rest_;
  std::size_t max_gap_ = 0;  // frames
  std::optional<std::size_t> donor_;
  std::vector<std::size_t> companions_;
  std::optional<Automatic> automatic_;
  std::optional<Trajectories> rough_;  // where there is no automatic_ that has it
};

}  // namespace kinemesh::fill
