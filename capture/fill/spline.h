// Gap filling from the marker's own trajectory: natural splines in time.
#pragma once

#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// The natural interpolating spline of degree 1, 3 or 5 through the measured samples nearest to
/// the gap, up to eight on each side (more change nothing that can be seen: their influence falls
/// by a factor of four per sample). Natural: the function of least ∫(f⁽ⁿ⁾)², n = 1, 2, 3, linear,
/// straight or parabolic outside. Nothing for gaps at the ends of the take, where a spline would
/// run away, or with fewer than n samples in all. The uncertainty is left empty.
std::optional<Estimate> fill_spline(const Trajectories& take, const GapAt& gap, int degree);

/// Values at `queries` of the natural spline of `degree` 1, 3 or 5 through (knots, values): knots
/// ascending, at least (degree + 1) / 2 of them; one row of `values` per knot, one column per
/// coordinate.
Eigen::MatrixXd natural_spline(int degree, const Eigen::VectorXd& knots,
                               const Eigen::MatrixXd& values, const Eigen::VectorXd& queries);

}  // namespace kinemesh::fill
