// Files of features.
//
// JSON: {"format": "kinemesh features", "version": 1, "animation": NAME, "vertices": n,
//        "frames": m, "rate_hz": r, "diagonal_mm": d,
//        "features": [{"vertex": 17, "frame": 3, "time_s": 0.05, "sigma_mm": 6.1, "tau_s": 0.04,
//                      "response": 0.2, "kind": "deformation",
//                      "descriptors": {"displacement": [ … ], "deformation": [ … ],
//                                      "anim_mesh_hog": [ … ]}}, …]}
// CSV:  vertex,frame,time_s,sigma_mm,tau_s,response,kind     one line per feature
// Vertices and frames count from 0.
#pragma once

#include <filesystem>
#include <string>

#include "analysis/feature.h"

namespace kinemesh {

/// The document; every number reads back exactly.
std::string features_json(const FeatureSet& set);
/// Without the descriptors.
std::string features_csv(const FeatureSet& set);

/// By extension: .csv, otherwise JSON. The file appears whole or not at all.
void write_features(const std::filesystem::path& path, const FeatureSet& set);

/// Reads JSON. Throws InputError naming file and feature for whatever is malformed: a vertex or
/// frame that does not exist, numbers that are not finite, a descriptor of the wrong length.
FeatureSet read_features(const std::filesystem::path& path);

}  // namespace kinemesh
