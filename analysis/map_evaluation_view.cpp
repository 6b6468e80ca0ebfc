#include "analysis/map_evaluation_view.h"

namespace kinemesh {
namespace {

Series curve_of(const std::string& label, const MapErrors& errors, double cutoff,
                std::size_t colour) {
  constexpr int steps = 400;
  Series series{.label = label, .colour = series_colour(colour)};
  for (int k = 0; k <= steps; ++k) {
    const double error = cutoff * k / steps;
    series.x.push_back(error);
    series.y.push_back(100.0 * errors.share_within(error));
  }
  return series;
}

}  // namespace

LineChart error_curves(const std::vector<std::string>& names,
                       const std::vector<MapEvaluation>& evaluations, double cutoff) {
  LineChart chart;
  chart.title = "Places whose geodesic error is at most so large";
  chart.x = {.label = "geodesic error", .unit = "√area", .low = 0.0, .high = cutoff};
  chart.y = {.label = "places", .unit = "%", .low = 0.0, .high = 100.0};
  for (std::size_t k = 0; k < evaluations.size(); ++k) {
    chart.series.push_back(curve_of(names[k], evaluations[k].errors, cutoff, k));
    if (!evaluations[k].either) continue;
    chart.series.push_back(
        curve_of(names[k] + ", mirrored allowed", *evaluations[k].either, cutoff, k));
    chart.series.back().dashed = true;
  }
  return chart;
}

}  // namespace kinemesh
