// Gap filling from correlations between markers: Ø. Gløersen and P. Federolf, "Predicting missing
// marker trajectories in human motion data using marker intercorrelations", PLoS ONE 11(3), 2016.
#pragma once

#include "capture/fill/trajectories.h"

namespace kinemesh::fill {

/// Markers seen throughout the gap are expressed relative to their mean position, normalised to
/// unit variance and weighted by exp(−d²/2σ²) of their mean distance to the marker, σ = 200 mm.
/// Principal components (99 % of the summed singular values) of the complete frames with and
/// without the marker's columns are related by T = Vᵀ V₀, which maps the gap's frames to full
/// ones. As the paper's prediction jumps where it meets measured samples, the difference there is
/// taken out linearly. At most 60 markers are used, the nearest. Nothing when fewer than three
/// others are seen throughout, or fewer than 20 frames are complete.
std::optional<Estimate> fill_pca(const Trajectories& take, const GapAt& gap);

}  // namespace kinemesh::fill
