#include "analysis/feature_matching_io.h"

#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using Json = nlohmann::ordered_json;

Json as_json(const FeatureMatch& m, const FeatureSet& source, const FeatureSet& target) {
  return {{"source", m.source},
          {"target", m.target},
          {"source_vertex", source.features[m.source].vertex},
          {"target_vertex", target.features[m.target].vertex},
          {"descriptor", m.descriptor},
          {"geodesic", m.geodesic},
          {"orientation", m.orientation},
          {"distance_change", m.distance_change},
          {"offset", m.offset},
          {"misfit", m.misfit},
          {"energy", m.energy},
          {"runner_up", m.runner_up == unmatched ? Json(nullptr) : Json(m.runner_up)},
          {"margin", m.margin}};
}

Json list_of(const std::vector<FeatureMatch>& matches, const FeatureSet& source,
             const FeatureSet& target) {
  Json list = Json::array();
  for (const FeatureMatch& m : matches) list.push_back(as_json(m, source, target));
  return list;
}

}  // namespace

std::string matches_json(const FeatureMatching& matching, const FeatureSet& source,
                         const FeatureSet& target) {
  Json json{{"format", "kinemesh matches"},
            {"version", 1},
            {"source", source.animation},
            {"target", target.animation},
            {"energy", matching.solution.energy},
            {"bound", matching.solution.bound},
            {"certified", matching.solution.certified},
            {"assignments", matching.assignments},
            {"pairs", matching.pairs}};
  json["terms"] = {
      {"descriptor", matching.terms.descriptor},    {"geodesic", matching.terms.geodesic},
      {"orientation", matching.terms.orientation},  {"prior", matching.terms.prior},
      {"unmatched", matching.terms.unmatched_part}, {"coherence", matching.terms.coherence}};
  json["matches"] = list_of(matching.matches, source, target);
  json["rejected"] = list_of(matching.rejected, source, target);
  json["unmatched_source"] = matching.unmatched_source;
  json["unmatched_target"] = matching.unmatched_target;
  if (!matching.empty_reason.empty()) json["empty_reason"] = matching.empty_reason;
  return json.dump(1) + "\n";
}

std::string matches_csv(const FeatureMatching& matching, const FeatureSet& source,
                        const FeatureSet& target) {
  std::string text =
      "source,target,source_vertex,target_vertex,descriptor,geodesic,orientation,distance_change,"
      "offset,misfit,energy,"
      "runner_up,margin\n";
  for (const FeatureMatch& m : matching.matches) {
    text += std::to_string(m.source) + ',' + std::to_string(m.target) + ',' +
            std::to_string(source.features[m.source].vertex) + ',' +
            std::to_string(target.features[m.target].vertex);
    for (const double value : {m.descriptor, m.geodesic, m.orientation, m.distance_change, m.offset,
                               m.misfit, m.energy}) {
      text += ',' + format_number(value);
    }
    text += ',' + (m.runner_up == unmatched ? std::string() : std::to_string(m.runner_up)) + ',' +
            format_number(m.margin) + '\n';
  }
  return text;
}

void check_matches_path(const std::filesystem::path& path) {
  const std::string extension = lower(path.extension().string());
  if (extension != ".json" && extension != ".csv") {
    throw UsageError({.what = "matches are written as .json or .csv, not '" + extension + "'",
                      .file = path.string(),
                      .remedy = "Name the output matches.json or matches.csv"});
  }
}

std::string matches_text(const std::filesystem::path& path, const FeatureMatching& matching,
                         const FeatureSet& source, const FeatureSet& target) {
  check_matches_path(path);
  return lower(path.extension().string()) == ".csv" ? matches_csv(matching, source, target)
                                                    : matches_json(matching, source, target);
}

void write_matches(const std::filesystem::path& path, const FeatureMatching& matching,
                   const FeatureSet& source, const FeatureSet& target) {
  write_file(path, matches_text(path, matching, source, target));
}

}  // namespace kinemesh
