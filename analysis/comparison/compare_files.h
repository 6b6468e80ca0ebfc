// From two files to all that a comparison writes: the page, JSON and tables. They appear together,
// or none of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/comparison/comparison_report.h"
#include "mesh/formats/registry.h"

namespace kinemesh {

struct CompareOptions {
  PerformanceOptions performance;
  ComparisonOptions comparison;
  bool anonymous = false;  ///< names of subjects and files are left out of all that is written

  void declare(ParameterSet& p);
  void validate() const;
};

/// What is compared; all but the first three may be empty.
struct CompareJob {
  std::string a, b;
  std::string output;                          ///< of the page; the other files lie beside it
  std::string map;                             ///< surface map A → B
  std::string landmarks;                       ///< pairs for the matching (mesh/landmarks.h)
  std::string regions;                         ///< JSON (regions.h)
  std::string measures;                        ///< JSON (measures.h)
  std::string truth;                           ///< true surface map A → B
  std::string program, command, options_toml;  ///< for the provenance
};

struct CompareFilesResult {
  ComparisonStory story;
  std::vector<std::filesystem::path> outputs;
};

/// Throws as read_performance and compare_performances; then nothing is left.
CompareFilesResult compare_files(const FormatRegistry& formats, const CompareJob& job,
                                 const CompareOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
