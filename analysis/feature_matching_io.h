// Files of matches.
//
// JSON: {"format": "kinemesh matches", "version": 1, "source": NAME, "target": NAME, "energy": e,
//        "bound": b, "certified": true, "terms": {"descriptor": …, "geodesic": …, "orientation": …,
//        "unmatched": …, "coherence": …},
//        "matches": [{"source": 0, "target": 3, "source_vertex": 17, "target_vertex": 99,
//                     "descriptor": …, "geodesic": …, "orientation": …, "energy": …,
//                     "runner_up": 5 or null, "margin": …}, …],
//        "rejected": [ … ], "unmatched_source": [ … ], "unmatched_target": [ … ]}
// CSV:  source,target,source_vertex,target_vertex,descriptor,geodesic,orientation,energy,runner_up,
//       margin     one line per match; an empty runner_up: staying unmatched
// Features count from 0 in the order of their files. docs/matching.md says what each term means.
#pragma once

#include <filesystem>
#include <string>

#include "analysis/feature_matching.h"

namespace kinemesh {

std::string matches_json(const FeatureMatching& matching, const FeatureSet& source,
                         const FeatureSet& target);
std::string matches_csv(const FeatureMatching& matching, const FeatureSet& source,
                        const FeatureSet& target);
/// By extension: .csv or .json; UsageError for another. The file appears whole or not at all.
void write_matches(const std::filesystem::path& path, const FeatureMatching& matching,
                   const FeatureSet& source, const FeatureSet& target);

}  // namespace kinemesh
