// Frame rates of files that store the times of their frames in single precision.
#pragma once

#include <cstddef>

namespace kinemesh {

/// Frames per second when `steps` frame intervals lie between two times in s; 0 when they do not
/// ascend. A whole number nearby is taken for it: 10⁻⁴ away, or as far as the precision of the
/// times reaches but no more than 10⁻³; 59.94 and 23.976 stay what they are, to three decimals.
double rate_from_float_times(double first, double last, std::size_t steps);

}  // namespace kinemesh
