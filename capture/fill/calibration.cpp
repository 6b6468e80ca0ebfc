#include "capture/fill/calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "capture/gap_fill.h"

namespace kinemesh::fill {
namespace {

struct Block {
  std::size_t begin = 0, end = 0;  // rows [begin, end)
};

/// Disjoint blocks whose neighbours on both sides are about as far apart as those of the gap.
std::vector<Block> blocks_like(const TrainingSet& set) {
  const std::size_t span = set.gap.size() + 1;
  const auto apart = [&](std::size_t begin, std::size_t end) {
    return set.rows[end] - set.rows[begin - 1];
  };
  std::vector<Block> blocks;
  for (std::size_t begin = 1; begin + 1 < set.rows.size();) {
    std::size_t end = begin + 1;
    while (end + 1 < set.rows.size() && apart(begin, end + 1) <= span) ++end;
    // One row more when that comes closer.
    if (end + 1 < set.rows.size() && apart(begin, end) < span &&
        apart(begin, end + 1) - span < span - apart(begin, end)) {
      ++end;
    }
    const bool alike = 2 * apart(begin, end) >= span && 2 * apart(begin, end) <= 3 * span + 4;
    if (alike) blocks.push_back({begin, end});
    begin = alike ? end + 1 : begin + 1;
  }
  return blocks;
}

}  // namespace

double band_factor(const TrainingSet& set, const Dense& factor, const Eigen::MatrixXd& alpha,
                   double scale) {
  const std::vector<Block> blocks = blocks_like(set);
  if (blocks.empty()) return 1.0;
  const Dense w = inverse_of_upper(factor);
  const std::size_t n = w.rows();
  std::vector<double> ratios;
  for (const Block& block : blocks) {
    const auto size = static_cast<Eigen::Index>(block.end - block.begin);
    Eigen::MatrixXd precision(size, size);
    for (Eigen::Index a = 0; a < size; ++a) {
      for (Eigen::Index b = a; b < size; ++b) {
        const std::size_t row_a = block.begin + static_cast<std::size_t>(a);
        const std::size_t row_b = block.begin + static_cast<std::size_t>(b);
        double sum = 0.0;
        for (std::size_t k = row_b; k < n; ++k) sum += w(row_a, k) * w(row_b, k);
        precision(a, b) = precision(b, a) = sum;
      }
    }
    const Eigen::MatrixXd covariance = precision.llt().solve(Eigen::MatrixXd::Identity(size, size));
    const Eigen::MatrixXd residuals =
        covariance * alpha.middleRows(static_cast<Eigen::Index>(block.begin), size);
    for (Eigen::Index a = 0; a < size; ++a) {
      const double radius = fill_band_90 * std::sqrt(scale * covariance(a, a));
      if (radius > 0.0) ratios.push_back(residuals.row(a).norm() / radius);
    }
  }
  if (ratios.empty()) return 1.0;
  const auto at =
      static_cast<std::size_t>(std::lround(0.9 * static_cast<double>(ratios.size() - 1)));
  std::ranges::nth_element(ratios, ratios.begin() + static_cast<std::ptrdiff_t>(at));
  constexpr double least = 0.3;  // a factor outside these bounds says more about few blocks
  constexpr double most = 5.0;   // than about the process
  return std::clamp(ratios[at], least, most);
}

}  // namespace kinemesh::fill
