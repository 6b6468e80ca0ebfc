#include "capture/fill/trajectories.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinemesh::fill {

Trajectories::Trajectories(const MarkerSequence& take)
    : frames_(take.frame_count()),
      markers_(take.marker_count()),
      rate_hz_(take.rate_hz),
      xyz_(3 * frames_ * markers_, 0.0),
      measured_(frames_ * markers_, 0),
      means_(markers_, Eigen::Vector3d::Zero()),
      counts_(markers_, 0) {
  for (std::size_t f = 0; f < frames_; ++f) {
    for (std::size_t m = 0; m < markers_; ++m) {
      const auto p = take.position(f, m);
      if (!take.valid(f, m) || !p.allFinite()) continue;
      const std::size_t i = m * frames_ + f;
      measured_[i] = 1;
      for (int c = 0; c < 3; ++c) xyz_[3 * i + static_cast<std::size_t>(c)] = p[c];
    }
  }
  for (std::size_t m = 0; m < markers_; ++m) update(m);
}

void Trajectories::update(std::size_t marker) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t f = 0; f < frames_; ++f) {
    if (!measured(marker, f)) continue;
    sum += at(marker, f);
    ++count;
  }
  counts_[marker] = count;
  means_[marker] = count > 0 ? Eigen::Vector3d(sum / static_cast<double>(count)) : sum;
}

bool Trajectories::measured_throughout(std::size_t marker, FrameRange range) const {
  const auto* first = measured_.data() + marker * frames_;
  return std::all_of(first + range.begin, first + range.end, [](uint8_t v) { return v != 0; });
}

std::vector<FrameRange> Trajectories::gaps(std::size_t marker) const {
  std::vector<FrameRange> out;
  for (std::size_t f = 0; f < frames_; ++f) {
    if (measured(marker, f)) continue;
    FrameRange gap{f, f};
    while (gap.end < frames_ && !measured(marker, gap.end)) ++gap.end;
    out.push_back(gap);
    f = gap.end;
  }
  return out;
}

std::vector<std::size_t> Trajectories::nearest(std::size_t marker) const {
  std::vector<std::size_t> out;
  for (std::size_t m = 0; m < markers_; ++m) {
    if (m != marker && counts_[m] > 0) out.push_back(m);
  }
  std::ranges::stable_sort(
      out, {}, [&](std::size_t m) { return (means_[m] - means_[marker]).squaredNorm(); });
  return out;
}

void Trajectories::put(std::size_t marker, std::size_t frame, const Eigen::Vector3d& position) {
  const std::size_t i = marker * frames_ + frame;
  measured_[i] = 1;
  std::copy_n(position.data(), 3, xyz_.data() + 3 * i);
}

void Trajectories::forget(std::size_t marker, FrameRange range) {
  for (std::size_t f = range.begin; f < range.end; ++f) {
    const std::size_t i = marker * frames_ + f;
    measured_[i] = 0;
    std::fill_n(xyz_.data() + 3 * i, 3, std::numeric_limits<double>::quiet_NaN());
  }
  update(marker);
}

}  // namespace kinemesh::fill
