#include "reconstruct/marker_spacing.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kinemesh {

MarkerSpacing measure_spacing(const Points& points) {
  constexpr std::size_t nearest = 5;
  MarkerSpacing spacing;
  spacing.of_vertex.assign(points.size(), 0.0);
  if (points.size() < 2) return spacing;
  const std::size_t count = std::min(nearest, points.size() - 1);
  std::vector<double> squared;
  for (std::size_t i = 0; i < points.size(); ++i) {
    squared.clear();
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (j != i) squared.push_back((points[j] - points[i]).squaredNorm());
    }
    std::partial_sort(squared.begin(), squared.begin() + static_cast<std::ptrdiff_t>(count),
                      squared.end());
    double sum = 0.0;
    for (std::size_t k = 0; k < count; ++k) sum += std::sqrt(squared[k]);
    spacing.of_vertex[i] = sum / static_cast<double>(count);
  }
  spacing.mean = std::accumulate(spacing.of_vertex.begin(), spacing.of_vertex.end(), 0.0) /
                 static_cast<double>(points.size());
  return spacing;
}

}  // namespace kinemesh
