// Whether a match is where the other matches say it should be. Internal to analysis.
//
// Two views that err independently, in √area: how much the match's distances over the surface to
// the others change (which no pose disturbs), and how far it lies from where a smooth map through
// the others puts it (which tells directions, too): Gaussian process regression (Rasmussen &
// Williams 2006, 2.2) of the displacement between both rest shapes after a similarity, with an
// affine part and a rough one. Where the rest shapes differ by more than that map allows, as in
// another pose, the second view counts less.
#pragma once

#include <vector>

#include "analysis/feature_energy.h"
#include "analysis/feature_matching.h"

namespace kinemesh {

/// Fills distance_change, offset and misfit of each match from the others; all indices are places'.
void fill_misfits(const FeatureEnergy& energy, std::vector<FeatureMatch>& matches);

/// Takes back the worst match until the misfits of all are within `limit`, or three are left; 0:
/// takes back none.
void take_back_misfits(const FeatureEnergy& energy, double limit,
                       std::vector<FeatureMatch>& matches, std::vector<FeatureMatch>& rejected);

}  // namespace kinemesh
