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
/// Throws UsageError unless the extension is .csv or .json.
void check_matches_path(const std::filesystem::path& path);
/// CSV or JSON by the extension; throws as check_matches_path().
std::string matches_text(const std::filesystem::path& path, const FeatureMatching& matching,
                         const FeatureSet& source, const FeatureSet& target);
/// The same as a file, which appears whole or not at all.
void write_matches(const std::filesystem::path& path, const FeatureMatching& matching,
                   const FeatureSet& source, const FeatureSet& target);

}  // namespace kinemesh
