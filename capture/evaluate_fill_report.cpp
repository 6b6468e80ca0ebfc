#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/evaluate_fill.h"
#include "config/text.h"

namespace kinemesh {
namespace {

std::string cell(double value, int decimals, std::size_t width) {
  const std::string text = std::isfinite(value) ? format_fixed(value, decimals) : "-";
  return std::string(width - std::min(width - 1, text.size()), ' ') + text;
}

}  // namespace

std::string evaluate_fill_text(const EvaluateFillResult& result) {
  std::string text;
  for (const std::string& done : result.repaired) text += "first: " + done + "\n";
  text += "Error of a gap of " + count_of(result.gap_frames, "frame") +
          " in mm (root mean square over its frames, 3D), over gaps; samples in the 90 % band in "
          "percent, its mean radius in mm:\n"
          "method      gaps  not filled    median      90 %   maximum  in band  radius\n";
  for (const FillScore& s : result.scores) {
    const std::string name(name_of(s.method));
    text += name + std::string(10 - std::min<std::size_t>(10, name.size()), ' ') +
            cell(static_cast<double>(s.gaps), 0, 6) +
            cell(static_cast<double>(s.not_filled), 0, 12) + cell(s.median_mm, 3, 10) +
            cell(s.percentile_90_mm, 3, 10) + cell(s.maximum_mm, 3, 10) +
            cell(s.within_band_percent, 1, 9) + cell(s.band_width_mm, 2, 8) + "\n";
  }
  return text;
}

std::string evaluate_fill_json(const EvaluateFillResult& result, const EvaluateFillOptions& options,
                               const std::string& file) {
  using Json = nlohmann::ordered_json;
  const auto number = [](double v) { return std::isfinite(v) ? Json(v) : Json(); };
  Json json = {{"file", file},
               {"markers", options.markers},
               {"gap_s", options.gap_s},
               {"gap_frames", result.gap_frames},
               {"trials", options.trials},
               {"noise_mm", options.noise_mm},
               {"candidates", result.candidates},
               {"repaired", result.repaired},
               {"methods", Json::array()},
               {"warnings", result.warnings}};
  for (const FillScore& s : result.scores) {
    json["methods"].push_back({{"method", name_of(s.method)},
                               {"gaps", s.gaps},
                               {"not_filled", s.not_filled},
                               {"median_mm", number(s.median_mm)},
                               {"percentile_90_mm", number(s.percentile_90_mm)},
                               {"maximum_mm", number(s.maximum_mm)},
                               {"within_band_percent", number(s.within_band_percent)},
                               {"band_width_mm", number(s.band_width_mm)},
                               {"ms_per_gap", number(s.ms_per_gap)}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kinemesh
