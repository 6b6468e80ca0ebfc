// What a comparison says: a page for people, JSON and tables for programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/comparison/asymmetry.h"
#include "analysis/comparison/comparison.h"
#include "analysis/comparison/measures.h"
#include "analysis/comparison/performance.h"
#include "analysis/comparison/regions.h"
#include "analysis/map_evaluation.h"
#include "config/run_context.h"

namespace kinemesh {

/// All that is told about one comparison. Texts are already without names where none may appear.
struct ComparisonStory {
  Performance a, b;
  Comparison comparison;
  std::vector<RegionResult> regions;  ///< the first is the whole surface
  std::vector<MeasureResult> measures;
  std::vector<AsymmetryRow> asymmetry;
  std::optional<MapEvaluation> truth;
  double truth_cutoff = 0.25;
  std::string name_a = "A", name_b = "B";
  Provenance provenance;
};

/// What must be known before anything else is read, the gravest first: full sentences.
std::vector<std::string> doubts_of(const ComparisonStory& story);

/// A single HTML file that works offline. Throws as MeshViewer.
std::string comparison_html(const ComparisonStory& story, const RunContext& ctx = {});
std::string comparison_json(const ComparisonStory& story);
/// measure, performance, rest_mm, change_mm, peak_speed_mm_s, onset_ms, peak_ms, offset_ms
std::string measures_csv(const ComparisonStory& story);
/// region, performance, largest_mm, largest_strain_percent, onset_ms, …, shape and motion
/// differences
std::string regions_csv(const ComparisonStory& story);
/// a_s, b_s, then for each region and measure A's value and B's in A's time
std::string curves_csv(const ComparisonStory& story);

/// A curve of B, kept in its own time, at each frame of A.
std::vector<double> in_time_of_a(const Comparison& c, const std::vector<double>& of_b);

}  // namespace kinemesh
