#include "capture/fill/automatic.h"

#include "capture/fill/companions.h"
#include "capture/fill/left_out.h"
#include "capture/fill/spline.h"

namespace kinemesh::fill {

Estimate Automatic::fill(const GapAt& gap) const {
  constexpr double spline_up_to_s = 0.1;
  const Method by_spline = [this](const GapAt& at) { return fill_spline(take_, at, 3); };
  const Method by_neighbours = [this](const GapAt& at) {
    const auto near = seen_throughout(take_, at, take_.nearest(at.marker), 8);
    auto rigid = fill_rigid(take_, at, near);
    return rigid || near.empty() ? rigid : fill_pattern(take_, at, near.front());
  };
  const bool is_short = static_cast<double>(gap.frames.size()) <= spline_up_to_s * take_.rate_hz();
  for (const Method& method :
       {is_short ? by_spline : by_neighbours, is_short ? by_neighbours : by_spline}) {
    if (auto estimate = method(gap)) {
      set_sd_from_left_out(take_, gap, method, *estimate);
      return *estimate;
    }
  }
  Estimate held = fill_hold(take_, gap);
  set_sd_from_left_out(
      take_, gap, [this](const GapAt& at) { return fill_hold(take_, at); }, held);
  return held;
}

}  // namespace kinemesh::fill
