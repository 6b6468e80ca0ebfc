// How honest a Gaussian process is about a gap: measured on left-out blocks of its own rows.
#pragma once

#include "capture/fill/training_set.h"

namespace kinemesh::fill {

/// The factor by which standard deviations must be multiplied so that the predicted 90 % ball
/// holds 90 % of the errors. Blocks of rows that span as much time as the gap are left out in turn:
/// with K⁻¹ = WWᵀ, the residuals of block B are (K⁻¹_BB)⁻¹ α_B and their covariance is scale ×
/// (K⁻¹_BB)⁻¹ (Rasmussen & Williams 2006, eq. 5.12, for blocks). `factor`: U of the covariance;
/// `alpha` = K⁻¹ y, rows × 3.
double band_factor(const TrainingSet& set, const Dense& factor, const Eigen::MatrixXd& alpha,
                   double scale);

}  // namespace kinemesh::fill
