#include "capture/fill/common_frame.h"

#include <algorithm>

namespace kinemesh::fill {

CommonFrame::CommonFrame(const Trajectories& rough, const std::vector<std::size_t>& markers,
                         const std::vector<std::size_t>& frames, std::size_t row_count, int rounds)
    : poses_(frames.size()), count_(markers.size()) {
  positions_.reserve(frames.size() * count_);
  for (const std::size_t f : frames) {
    for (const std::size_t m : markers) positions_.emplace_back(rough.at(m, f));
  }
  if (count_ < 4 || row_count == 0) return;
  const auto first = at(first_shape(row_count));
  std::vector<Eigen::Vector3d> shape(first.begin(), first.end());
  std::vector<double> weights(count_, 1.0);
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t i = 0; i < frames.size(); ++i) poses_[i] = fit_rigid(shape, at(i), weights);
    if (round < rounds) average(row_count, shape, weights);
  }
}

Eigen::Vector3d CommonFrame::mean(std::size_t k, std::size_t rows) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < rows; ++i) sum += inside(i, k) / static_cast<double>(rows);
  return sum;
}

/// Mean shape over the rows; markers that move more count less.
void CommonFrame::average(std::size_t row_count, std::vector<Eigen::Vector3d>& shape,
                          std::vector<double>& weights) const {
  std::vector<double> variance(count_, 0.0);
  for (std::size_t k = 0; k < count_; ++k) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < row_count; ++i) sum += inside(i, k);
    shape[k] = sum / static_cast<double>(row_count);
    for (std::size_t i = 0; i < row_count; ++i) {
      variance[k] += (inside(i, k) - shape[k]).squaredNorm();
    }
  }
  std::vector<double> sorted = variance;
  std::ranges::sort(sorted);
  const double median = sorted[count_ / 2];
  if (median <= 0.0) return;
  for (std::size_t k = 0; k < count_; ++k) weights[k] = median / (variance[k] + median);
}

}  // namespace kinemesh::fill
