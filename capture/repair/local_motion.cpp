#include "capture/repair/local_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "capture/rigid_fit.h"

namespace kinemesh::repair {
namespace {

constexpr std::size_t most_neighbours = 12;
constexpr std::size_t asked = 10;  // neighbours that a prediction rests on, at most

Eigen::Vector3d median_of(std::vector<Eigen::Vector3d>& all) {
  Eigen::Vector3d out;
  std::vector<double> values(all.size());
  for (Eigen::Index c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < all.size(); ++i) values[i] = all[i][c];
    out[c] = repair::median_of(values);
  }
  return out;
}

/// Median over the take of how far a marker's step from one frame to the next is from that of its
/// neighbours.
double usual_deviation(const LocalMotion& motion, std::size_t m) {
  constexpr std::size_t most_samples = 100;
  const std::size_t stride = std::max<std::size_t>(1, motion.frames() / most_samples);
  std::vector<double> deviations;
  for (std::size_t f = 1; f < motion.frames(); f += stride) {
    if (!motion.has(f, m) || !motion.has(f - 1, m)) continue;
    const auto common = motion.displacement(m, f - 1, f);
    if (common) deviations.push_back((motion.at(f, m) - motion.at(f - 1, m) - *common).norm());
  }
  return deviations.empty() ? 0.0 : repair::median_of(deviations);
}

}  // namespace

double least_jump(const LocalMotion& motion, std::size_t m) {
  constexpr double share = 0.35;
  constexpr double least_mm = 1.5;
  constexpr double of_usual = 3.0;
  return std::max({least_mm, share * motion.spacing(m), of_usual * usual_deviation(motion, m)});
}

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

LocalMotion::LocalMotion(std::size_t frames, const std::vector<Eigen::Vector3d>& places)
    : frames_(frames),
      markers_(places.size()),
      positions_(frames * places.size(), Eigen::Vector3d::Zero()),
      seen_(frames * places.size(), 0),
      neighbours_(places.size()),
      spacing_(places.size(), std::numeric_limits<double>::infinity()) {
  for (std::size_t m = 0; m < markers_; ++m) {
    if (!places[m].allFinite()) continue;
    std::vector<std::pair<double, std::size_t>> others;
    for (std::size_t k = 0; k < markers_; ++k) {
      if (k != m && places[k].allFinite()) others.emplace_back((places[k] - places[m]).norm(), k);
    }
    if (others.empty()) continue;
    const std::size_t kept = std::min(most_neighbours, others.size());
    std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(kept));
    spacing_[m] = others.front().first;
    for (std::size_t k = 0; k < kept; ++k) neighbours_[m].push_back(others[k].second);
  }
}

LocalMotion LocalMotion::of(const MarkerSequence& take, std::span<const std::size_t> columns) {
  constexpr std::size_t most_samples = 200;  // for a median that says who is whose neighbour
  const std::size_t stride = std::max<std::size_t>(1, take.frame_count() / most_samples);
  // In relation to the centre of what is seen, so that head motion does not blur the places.
  std::vector<std::vector<Eigen::Vector3d>> samples(columns.size());
  for (std::size_t f = 0; f < take.frame_count(); f += stride) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const std::size_t m : columns) {
      if (!measured(take, f, m)) continue;
      centre += take.position(f, m).cast<double>();
      count += 1.0;
    }
    if (count < 1.0) continue;
    centre /= count;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (!measured(take, f, columns[k])) continue;
      samples[k].emplace_back(take.position(f, columns[k]).cast<double>() - centre);
    }
  }
  std::vector<Eigen::Vector3d> places(columns.size(), Eigen::Vector3d::Constant(std::nan("")));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (!samples[k].empty()) places[k] = median_of(samples[k]);
  }
  LocalMotion out(take.frame_count(), places);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (measured(take, f, columns[k])) {
        out.put(f, k, take.position(f, columns[k]).cast<double>());
      }
    }
  }
  return out;
}

void LocalMotion::put(std::size_t f, std::size_t m, const Eigen::Vector3d& p) {
  positions_[f * markers_ + m] = p;
  seen_[f * markers_ + m] = 1;
}

void LocalMotion::swap(std::size_t a, std::size_t b, std::size_t from) {
  for (std::size_t f = from; f < frames_; ++f) {
    std::swap(positions_[f * markers_ + a], positions_[f * markers_ + b]);
    std::swap(seen_[f * markers_ + a], seen_[f * markers_ + b]);
  }
}

std::optional<Eigen::Vector3d> LocalMotion::displacement(std::size_t m, std::size_t from,
                                                         std::size_t to) const {
  std::array<std::array<double, asked>, 3> moved{};
  std::size_t count = 0;
  for (const std::size_t n : neighbours_[m]) {
    if (count == asked) break;
    if (!has(from, n) || !has(to, n)) continue;
    const Eigen::Vector3d d = at(to, n) - at(from, n);
    for (std::size_t c = 0; c < 3; ++c) moved[c][count] = d[static_cast<Eigen::Index>(c)];
    ++count;
  }
  if (count == 0) return std::nullopt;
  Eigen::Vector3d out;
  for (std::size_t c = 0; c < 3; ++c) {
    auto* const middle = moved[c].data() + count / 2;
    std::nth_element(moved[c].data(), middle, moved[c].data() + count);
    out[static_cast<Eigen::Index>(c)] = *middle;
  }
  return out;
}

Eigen::Vector3d LocalMotion::carried(std::size_t m, const Eigen::Vector3d& position,
                                     std::size_t from, std::size_t to,
                                     std::span<const std::size_t> without) const {
  std::vector<Eigen::Vector3d> before, after;
  for (const std::size_t n : neighbours_[m]) {
    if (before.size() == asked) break;
    if (!has(from, n) || !has(to, n) || std::ranges::find(without, n) != without.end()) continue;
    before.push_back(at(from, n));
    after.push_back(at(to, n));
  }
  if (before.empty()) return position;
  if (before.size() >= 4) {
    const double range = std::max(1.0, (before[before.size() / 2] - position).norm());
    std::vector<double> weights;
    for (const Eigen::Vector3d& p : before) {
      weights.push_back(std::exp(-0.5 * (p - position).squaredNorm() / (range * range)));
    }
    RigidFit fit = fit_rigid(before, after, weights);
    if (before.size() >= 6) {
      for (int worst = 0; worst < 2; ++worst) {
        std::size_t out = 0;
        double most = -1.0;
        for (std::size_t i = 0; i < before.size(); ++i) {
          const double error = (fit.apply(before[i]) - after[i]).squaredNorm();
          if (weights[i] > 0.0 && error > most) {
            most = error;
            out = i;
          }
        }
        weights[out] = 0.0;
      }
      fit = fit_rigid(before, after, weights);
    }
    if (fit.spread > 1.0) return fit.apply(position);
  }
  std::vector<Eigen::Vector3d> moved;
  for (std::size_t i = 0; i < before.size(); ++i) moved.emplace_back(after[i] - before[i]);
  return position + median_of(moved);
}

}  // namespace kinemesh::repair
